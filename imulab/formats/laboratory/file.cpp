#include "imulab/formats/laboratory/file.hpp"

#include "imulab/core/stamp_text.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/toml_fields.hpp"

#include <fmt/format.h>

#include <optional>
#include <utility>
#include <vector>

namespace imulab {
namespace {

using text::TomlFields;

constexpr std::size_t longest_text = 400;  // bytes: the first two pages of a certificate have room for as much

struct LaboratoryKey {
  std::string_view name;
  std::string* value;
};

void read_texts(TomlFields& f, const std::vector<LaboratoryKey>& keys) {
  for (const LaboratoryKey& key : keys) {
    std::optional<std::string> given;
    f.text(key.name, given);
    if (given) *key.value = std::move(*given);
    f.check(key.value->size() <= longest_text, key.name,
            fmt::format("has more than {} bytes; expected less, or the name of a document", longest_text));
  }
}

void read_table(TomlFields& f, std::string_view table, const std::vector<LaboratoryKey>& keys) {
  f.table(table, text::Presence::optional, [&](TomlFields& own) { read_texts(own, keys); });
}

bool is_day(const std::string& text) { return text.empty() || is_date(text); }

}  // namespace

Laboratory parse_laboratory(std::string_view text, const std::string& file) {
  TomlFields f(file, text);
  Laboratory lab;
  f.format("imulab.laboratory/1");
  read_texts(f, {{"name", &lab.name},
                 {"address", &lab.address},
                 {"accreditation", &lab.accreditation},
                 {"traceability", &lab.traceability},
                 {"issued", &lab.issued}});
  read_table(f, "customer", {{"name", &lab.customer.name}, {"address", &lab.customer.address}, {"information", &lab.customer.information}});
  f.table("item", text::Presence::optional, [&](TomlFields& item) {
    read_texts(item, {{"manufacturer", &lab.item.manufacturer},
                      {"type", &lab.item.type},
                      {"condition", &lab.item.condition},
                      {"received", &lab.item.received},
                      {"adjustment", &lab.item.adjustment}});
    item.check(is_day(lab.item.received), "received", "is no date; expected one as in \"2026-03-31\"");
  });
  read_table(f, "conditions",
             {{"place", &lab.conditions.place},
              {"temperature", &lab.conditions.temperature},
              {"humidity", &lab.conditions.humidity},
              {"pressure", &lab.conditions.pressure}});
  read_table(f, "procedure", {{"name", &lab.procedure.name}, {"deviations", &lab.procedure.deviations}});
  read_table(f, "signatory", {{"name", &lab.signatory.name}, {"function", &lab.signatory.function}});
  f.done();
  f.check(is_day(lab.issued), "issued", "is no date; expected one as in \"2026-03-31\"");
  return lab;
}

Laboratory read_laboratory(const std::filesystem::path& path) {
  const MappedFile mapped(path, Content::settings);
  return parse_laboratory(mapped.text(), input_name(path));
}

}  // namespace imulab
