// Folders, archives and workbooks whose tables are texts.
#include "imulab/formats/recording/archive/text_tables.hpp"

#include "imulab/core/memory.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/recording/signals.hpp"
#include "imulab/formats/recording/table_reader.hpp"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include "tests/temporary_folder.hpp"
#include "tests/zip_file.hpp"

namespace imulab {
namespace {

using recording_io::TableRows;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// 40 rows of one sensor of a phone, as apps write them.
std::string phone_text(const std::string& header, double size, char delimiter = ',') {
  std::string text = header + "\n";
  for (int i = 0; i < 40; ++i)
    text += fmt::format("{1}{0}{2:.3f}{0}{3:.4f}{0}{4:.4f}{0}{5:.4f}\n", delimiter, 1'700'000'000'000'000'000 + 10'000'000LL * i, 0.01 * i, size,
                        size + 0.25 * i, -size);
  return text;
}
const std::string phone_header = "time,seconds_elapsed,z,y,x";

using Texts = std::vector<std::pair<std::string, std::string>>;
Texts phone_texts() {
  return {{"Metadata.csv", "version,device name\n3,Some Phone\n"},
          {"Accelerometer.csv", phone_text(phone_header, 0.1)},
          {"AccelerometerUncalibrated.csv", phone_text(phone_header, 9)},
          {"TotalAcceleration.csv", phone_text(phone_header, 9.8)},
          {"Gravity.csv", phone_text(phone_header, 9.8)},
          {"Gyroscope.csv", phone_text(phone_header, 0.5)}};
}

std::vector<std::string> taken(const std::vector<SignalTable>& tables) {
  std::vector<std::string> names;
  for (const SignalTable& table : tables) names.push_back(table.topic);
  return names;
}

struct TextTables : testing::Test {
  TemporaryFolder folder;
  std::filesystem::path write_folder(const Texts& texts) const {
    for (const auto& [name, text] : texts) {
      const std::string path = "log/" + name;
      std::filesystem::create_directories((folder / path).parent_path());
      folder.write(path, text);
    }
    return folder / "log";
  }
};

TEST_F(TextTables, OfAPhoneAreItsGyrosAndWhatIncludesGravity) {
  for (const std::filesystem::path& path : {write_folder(phone_texts()), folder.write("phone.zip", zip_file(phone_texts()))}) {
    const std::vector<SignalTable> tables = read_tables(path);
    EXPECT_THAT(taken(tables), ElementsAre("Gyroscope", "TotalAcceleration")) << path;
    EXPECT_EQ(tables[0].signals[4].name, "Gyroscope.x");
    EXPECT_EQ(tables[1].signals[2].values[39], 9.8);
    EXPECT_THAT(tables[0].notes,
                testing::Contains(HasSubstr("TotalAcceleration was taken for the accelerometers; --topic takes others: Accelerometer")));
    const TableRows rows = recording_io::read_table({path, "Gyroscope", ""}, {.columns = {"x", "y"}, .time = {.column = "time", .unit = "ns"}});
    ASSERT_EQ(rows.size(), 40U);
    EXPECT_EQ(rows.time_ns[1], 1'700'000'000'010'000'000) << "exact";
    EXPECT_EQ(rows.columns[1].numbers[4], 1.5);
    EXPECT_THAT(
        [&] {
          recording_io::read_table({path, "Gyro", ""}, {.columns = {"x"}});
        },
        ThrowsMessage<Error>(HasSubstr("topic Gyro is not there; expected one of Accelerometer")));
    EXPECT_THAT(
        [&] {
          recording_io::read_table({path, "Gyroscope", ""}, {.columns = {"w"}});
        },
        ThrowsMessage<Error>(testing::AllOf(HasSubstr("Gyroscope.csv"), HasSubstr("column w is not there"))));
    EXPECT_FALSE(is_kept(path / "Gyroscope.csv")) << "what was unpacked is let go";
  }
}

TEST_F(TextTables, OfADataSetAreNotItsReference) {
  std::string imu = "t,w_x,w_y,w_z,a_x,a_y,a_z\n", truth = "t,p_x,b_w_x,b_w_y,b_w_z,b_a_x,b_a_y,b_a_z\n";
  for (int i = 0; i < 30; ++i) imu += fmt::format("{},1,2,3,4,5,{}\n", 0.01 * i, i), truth += fmt::format("{},0,1,2,3,4,5,{}\n", 0.01 * i, i);
  const auto path = write_folder(
      {{"mav0/imu0/data.csv", imu}, {"mav0/state_groundtruth_estimate0/data.csv", truth}, {"mav0/cam0/data.csv", "#t,file\n1,1.png\n2,2.png\n"}});
  EXPECT_THAT(taken(read_tables(path)), ElementsAre("mav0/imu0/data"));
}

TEST_F(TextTables, SayWhatIsWrong) {
  EXPECT_THAT(
      [&] {
        read_tables(folder.write("a.zip", zip_file({{"a.png", "x"}})));
      },
      ThrowsMessage<Error>(HasSubstr("is an archive without texts; expected .csv, .tsv, .txt, .dat, .log files in it")));
  EXPECT_THAT(
      [&] {
        read_tables(folder.write("a.zip", zip_file({{"a.csv", "only words\n"}, {"b.txt", "and more\n"}})));
      },
      ThrowsMessage<Error>(HasSubstr("none of its 2 texts is a table of numbers")));
  EXPECT_THAT(
      [&] {
        read_tables(folder.write("a.zip", zip_file({{"a.csv", "only words\n"}})));
      },
      ThrowsMessage<Error>(HasSubstr("a.zip/a.csv")))
      << "of one alone, why";
  std::string damaged = zip_file({{"a.csv", phone_text(phone_header, 1)}});
  damaged[60] = static_cast<char>(damaged[60] ^ 0x55);
  EXPECT_THROW(read_tables(folder.write("a.zip", damaged)), Error);
  Texts many;
  for (int i = 0; i < 501; ++i) many.emplace_back(fmt::format("{}.csv", i), "1,2\n");
  EXPECT_THAT([&] { read_tables(folder.write("a.zip", zip_file(many))); },
              ThrowsMessage<Error>(HasSubstr("holds 501 texts; expected those of one recording")));
  EXPECT_THAT(
      [&] {
        read_tables(write_folder({{"a.json", "1"}}));
      },
      ThrowsMessage<Error>(HasSubstr("is a folder without a recording that is known here")));
}

TEST_F(TextTables, AreNotUnpackedBeyondTheMemoryAllowed) {
  std::string rows = "t,gx,gy,gz,ax,ay,az\n";
  while (rows.size() < (1 << 22)) rows += "1,0,0,0,0,0,0\n";
  const auto bomb = folder.write("bomb.zip", zip_file({{"a.csv", rows}}));
  EXPECT_LT(std::filesystem::file_size(bomb), rows.size() / 100);
  const MemoryLimit limit(std::uint64_t{1} << 22);
  EXPECT_THAT([&] { read_tables(bomb); }, ThrowsMessage<MemoryError>(HasSubstr("bomb.zip/a.csv: unpacking it takes about")));
  const auto lying = folder.write("lying.zip", zip_file({{"a.csv", std::string(100, '1')}}, 4'000'000'000));
  EXPECT_THROW(read_tables(lying), Error);
}

// ---- workbooks

std::string sheet_xml(const std::string& rows) {
  return "<?xml version=\"1.0\"?>\n<worksheet xmlns=\"x\"><dimension ref=\"A1:G9\"/><!-- <row> --><sheetData>" + rows + "</sheetData></worksheet>";
}

std::string workbook_file(const std::string& sheet, const std::string& texts = "<sst><si><t>t</t></si></sst>") {
  return zip_file({{"[Content_Types].xml", "<Types/>"},
                   {"xl/workbook.xml",
                    "<workbook><sheets><sheet name=\"Log\" sheetId=\"4\" r:id=\"rId9\"/><sheet name=\"Other\" r:id=\"rId1\"/></sheets></workbook>"},
                   {"xl/_rels/workbook.xml.rels",
                    "<Relationships><Relationship Id=\"rId1\" Target=\"worksheets/sheet1.xml\"/>"
                    "<Relationship Target=\"worksheets/sheet4.xml\" Id=\"rId9\"/></Relationships>"},
                   {"xl/sharedStrings.xml", texts},
                   {"xl/worksheets/sheet1.xml", sheet_xml("")},
                   {"xl/worksheets/sheet4.xml", sheet}});
}

TEST_F(TextTables, OfAWorkbookIsItsFirstSheet) {
  std::string rows =
      "<row r=\"1\"><c r=\"A1\" t=\"s\"><v>0</v></c><c r=\"B1\" t=\"inlineStr\"><is><t>gx [rad/s]</t></is></c><c t=\"str\"><f>1</f><v>gy &amp; "
      "so</v></c></row>";
  for (int i = 0; i < 30; ++i)
    rows += fmt::format("<row r=\"{0}\"><c r=\"A{0}\" s=\"1\"><v>{1:.2f}</v></c><c r=\"B{0}\"><v>1.5</v></c><c r=\"C{0}\"><v>1E-3</v></c></row>",
                        i + 2, 0.01 * i);
  const auto path = folder.write("log.xlsx", workbook_file(sheet_xml(rows)));
  const SignalTable table = read_tables(path).front();
  EXPECT_EQ(table.topic, "");
  EXPECT_THAT(table.format, HasSubstr("Excel workbook"));
  ASSERT_EQ(table.signals.size(), 3U);
  EXPECT_EQ(table.signals[1].name, "gx [rad/s]");
  EXPECT_EQ(table.signals[2].name, "gy & so");
  EXPECT_EQ(table.signals[2].values[3], 1e-3);
  EXPECT_EQ(table.rows(), 30U);
  EXPECT_EQ(recording_io::read_table({path, "", ""}, {.columns = {2}, .time = {.column = 1, .unit = "s"}}).time_ns[29], 290'000'000);
}

TEST_F(TextTables, OfAHostileWorkbookEndAtOnce) {
  std::string far;
  for (int i = 1; i < 2000; ++i) far += fmt::format("<row><c r=\"XFD{}\"><v>1</v></c></row>", i);
  EXPECT_THAT([&] { read_tables(folder.write("a.xlsx", workbook_file(sheet_xml(far)))); },
              ThrowsMessage<Error>(HasSubstr("its first sheet is mostly empty; expected a table of numbers")));
  for (const std::string& sheet : {std::string("<row><c t=\"s\"><v>99999999999999999999</v></c></row>"),
                                   std::string("<row><c r=\"ZZZZZZ1\"><v>1</v>"), std::string("<<<<>>>"), std::string("<c r="), std::string("<!--")})
    EXPECT_THROW(read_tables(folder.write("a.xlsx", workbook_file(sheet))), Error) << sheet;
  EXPECT_THROW(read_tables(folder.write("a.xlsx", zip_file({{"xl/x.xml", ""}}))), Error);
}

// ---- KITTI

TEST_F(TextTables, OfKittiAreItsRecordsWithTheirTimes) {
  Texts texts{{"oxts/timestamps.txt", ""}, {"image_00/timestamps.txt", "2011-09-26 13:02:25.964389445\n"}};
  for (int i = 0; i < 25; ++i) {
    texts[0].second += fmt::format("2011-09-26 13:02:{:02}.{:09}\n", 25 + i / 100, 964389445 - 900000000 + 10000000 * i);
    std::string row;
    for (int k = 0; k < 30; ++k) row += fmt::format("{}{}", k > 0 ? " " : "", k == 17 ? 0.5 * i : k);
    texts.emplace_back(fmt::format("oxts/data/{:010}.txt", i), row + "\n");
  }
  const auto path = write_folder(texts);
  for (const std::filesystem::path& place : {path, path / "oxts"}) {
    const SignalTable table = read_tables(place).front();
    EXPECT_THAT(table.format, HasSubstr("KITTI oxts folder"));
    const TableRows rows = recording_io::read_table(
        {place, "", ""}, {.columns = {"gyro.x [rad/s]", "accel.x [m/s^2]"}, .time = {.column = "timestamp_ns", .unit = "ns"}});
    ASSERT_EQ(rows.size(), 25U);
    EXPECT_EQ(rows.time_ns[0], 1'317'042'145'064'389'445);
    EXPECT_EQ(rows.columns[0].numbers[24], 12);
    EXPECT_EQ(rows.columns[1].numbers[24], 11);
  }
  folder.write("log/oxts/data/0000000003.txt", "1 2 3\n");
  EXPECT_THAT([&] { read_tables(path); }, ThrowsMessage<Error>(HasSubstr("0000000003.txt:1: has 3 fields; expected the 30 of an OXTS record")));
}

}  // namespace
}  // namespace imulab
