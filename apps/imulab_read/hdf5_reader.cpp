// HDF5 as libhdf5 reads it. Only what is requested is read, some rows at a time. Data outside the file, which a file may name, are not: by then
// nothing more can be opened.
#include "imulab/error.hpp"
#include "imulab/formats/recording/arrays/arrays.hpp"
#include "imulab/formats/recording/child/child_tables.hpp"
#include "imulab/formats/recording/logs/binary.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/recording/unit_names.hpp"

#include <fmt/core.h>

#include "apps/imulab_read/readers.hpp"
#include "apps/imulab_read/sandbox.hpp"
#include <algorithm>
#include <array>
#include <bit>
#include <filesystem>
#define H5_USE_110_API 1  // one signature in all versions
#include <hdf5.h>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/// In place of HDF5's own driver of files on the network, which would bring the libraries of that into the program.
extern "C" hid_t H5FD_ros3_init() { return H5I_INVALID_HID; }

namespace imulab::recording_io {
namespace {

/// An object of the library, which is closed at the end.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&&) = delete;
  operator hid_t() const { return id_; }
  bool good() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// A dataset of numbers.
struct Dataset {
  NumberArray array;
  std::string path, attribute;      // of the object there: a rate, which is one number
  std::vector<NumberField> fields;  // of an element in memory
  std::vector<hsize_t> dimensions;
  bool lying = false;        // 3 x N
  std::size_t element = 0;   // bytes in memory
  hsize_t rows_at_once = 1;  // so that no piece of the file is unpacked twice
};

struct OpenedFile {
  Handle file;
  std::string name;
  std::uintmax_t bytes = 0;
  bool matlab = false;  // version 7.3
};

OpenedFile open_hdf5(const std::filesystem::path& path) {
  bool matlab = false;
  std::uintmax_t bytes = 0;
  {
    const MappedFile mapped(path);
    bytes = mapped.text().size();
    matlab = mapped.text().starts_with("MATLAB 7.3");
  }
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // errors are ours to say
  OpenedFile opened{Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose), path.string(), bytes, matlab};
  if (!opened.file.good()) throw Error(opened.name + ": cannot be opened as HDF5; expected a whole file (is it truncated?)");
  return opened;
}

std::optional<NumberType> plain_type(hid_t native) {
  const std::size_t bytes = H5Tget_size(native);
  const bool big_endian = std::endian::native == std::endian::big;
  if (H5Tget_class(native) == H5T_INTEGER && std::has_single_bit(bytes) && bytes <= 8)
    return NumberType{H5Tget_sign(native) == H5T_SGN_NONE ? 'u' : 'i', bytes, big_endian};
  if (H5Tget_class(native) == H5T_FLOAT && (bytes == 4 || bytes == 8)) return NumberType{'f', bytes, big_endian};
  return std::nullopt;
}

/// Adds the numbers of an element: its own, or those of its members.
void add_fields(Dataset& dataset, hid_t native, const std::string& name, std::size_t offset, int depth) {
  constexpr std::size_t most = 4096;
  const H5T_class_t kind = H5Tget_class(native);
  if (const auto type = plain_type(native)) {
    dataset.fields.push_back({*type, offset});
    dataset.array.columns.push_back({name});
  } else if (kind == H5T_COMPOUND && depth < 8) {
    for (unsigned i = 0; i < static_cast<unsigned>(std::max(0, H5Tget_nmembers(native))) && dataset.fields.size() < most; ++i) {
      const Handle member(H5Tget_member_type(native, i), H5Tclose);
      char* const own = H5Tget_member_name(native, i);
      if (own != nullptr && member.good()) add_fields(dataset, member, name + "." + own, offset + H5Tget_member_offset(native, i), depth + 1);
      H5free_memory(own);
    }
  } else if (kind == H5T_ARRAY && depth < 8) {
    const Handle element(H5Tget_super(native), H5Tclose);
    const std::size_t size = element.good() ? H5Tget_size(element) : 0, count = size > 0 ? H5Tget_size(native) / size : 0;
    for (std::size_t k = 0; k < count && dataset.fields.size() < most; ++k)
      add_fields(dataset, element, fmt::format("{}.{}", name, k + 1), offset + k * size, depth + 1);
  }
}

/// Rows of a chunk, in which compressed datasets are stored.
hsize_t rows_of_chunk(hid_t dataset, std::size_t rank, std::size_t row_dimension) {
  const Handle properties(H5Dget_create_plist(dataset), H5Pclose);
  std::array<hsize_t, 2> chunk{1, 1};
  if (!properties.good() || H5Pget_layout(properties) != H5D_CHUNKED) return 1;
  if (H5Pget_chunk(properties, 2, chunk.data()) != static_cast<int>(rank)) return 1;
  return std::max<hsize_t>(1, chunk[row_dimension]);
}

/// The text of an attribute; empty where there is none, and where its length varies: the library reads beyond its memory where such a text is
/// damaged.
std::string text_attribute(hid_t dataset, const char* name) {
  if (H5Aexists(dataset, name) <= 0) return "";
  const Handle attribute(H5Aopen(dataset, name, H5P_DEFAULT), H5Aclose), type(H5Aget_type(attribute), H5Tclose);
  const Handle space(H5Aget_space(attribute), H5Sclose);
  const std::size_t size = type.good() ? H5Tget_size(type) : 0;
  if (!space.good() || size == 0 || size > 256 || H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) != 0 ||
      H5Sget_simple_extent_npoints(space) != 1)
    return "";
  std::string text(size, '\0');
  if (H5Aread(attribute, type, text.data()) < 0) return "";
  return text.substr(0, text.find('\0'));
}

/// The unit that a dataset states, where sessions have it.
std::string stated_unit(hid_t dataset) {
  for (const char* name : {"units", "unit"})
    if (const std::string text = text_attribute(dataset, name); !text.empty())
      for (const Quantity quantity : {Quantity::gyro, Quantity::accel, Quantity::temperature, Quantity::time})
        for (const bool increment : {false, true})
          for (const std::string_view unit : unit_names(quantity, increment))
            if (unit == text) return text;
  return "";
}

/// Structures of MATLAB are groups.
std::string matlab_name(const std::string& path) {
  std::string name = path.substr(1);
  std::replace(name.begin(), name.end(), '/', '.');
  return name;
}

/// True if MATLAB stored numbers; texts, cells and objects look alike.
bool is_matlab_matrix(hid_t dataset, const std::string& path) {
  const std::string kind = text_attribute(dataset, "MATLAB_class");
  return !path.starts_with("/#") && H5Aexists(dataset, "MATLAB_empty") <= 0 &&
         (kind.find("int") != std::string::npos || kind == "double" || kind == "single" || kind == "logical");
}

/// A dataset as a table of numbers; no columns where it is none.
Dataset describe_dataset(const OpenedFile& file, hid_t id, const std::string& path) {
  Dataset dataset;
  dataset.path = path;
  const std::string name = dataset.array.name = file.matlab ? matlab_name(path) : path;
  const Handle type(H5Dget_type(id), H5Tclose), space(H5Dget_space(id), H5Sclose);
  const int rank = space.good() ? H5Sget_simple_extent_ndims(space) : -1;
  const Handle native(type.good() ? H5Tget_native_type(type, H5T_DIR_ASCEND) : -1, H5Tclose);
  if (rank < 0 || rank > 2 || (rank == 0 && H5Sget_simple_extent_npoints(space) != 1) || !native.good()) return dataset;
  dataset.dimensions.assign(static_cast<std::size_t>(std::max(1, rank)), 1);  // a number alone, as of a rate, is one row
  H5Sget_simple_extent_dims(space, dataset.dimensions.data(), nullptr);
  dataset.element = H5Tget_size(native);
  add_fields(dataset, native, name, 0, 0);
  const bool compound = H5Tget_class(native) == H5T_COMPOUND || H5Tget_class(native) == H5T_ARRAY;
  const ArrayShape shape = table_shape({dataset.dimensions.begin(), dataset.dimensions.end()}, true);
  if (dataset.fields.empty() || shape.columns == 0 || (compound && (rank != 1 || file.matlab))) {
    dataset.array.columns.clear();
    return dataset;
  }
  // No file holds much more than this, packed as well as deflate can; and sizes may be damaged.
  const double bytes = static_cast<double>(shape.rows) * static_cast<double>(shape.columns) * static_cast<double>(dataset.element);
  if (bytes > 1100.0 * static_cast<double>(file.bytes)) throw Error(fmt::format("{}: {}: is larger than the file can hold", file.name, path));
  dataset.array.rows = shape.rows;
  dataset.lying = rank == 2 && shape.by_column;
  if (!compound) dataset.array.columns = column_names(name, shape.columns, stated_unit(id));
  const std::size_t row = dataset.element * shape.columns;
  const hsize_t chunk = rows_of_chunk(id, dataset.dimensions.size(), dataset.lying ? 1 : 0);
  dataset.rows_at_once = std::max<hsize_t>(1, (1 << 20) / std::max<std::size_t>(row, 1));
  if (chunk * row <= (1 << 26)) dataset.rows_at_once = (dataset.rows_at_once + chunk - 1) / chunk * chunk;
  return dataset;
}

/// Rates that an object states as attributes: as datasets of one row would.
void add_rates(hid_t object, const std::string& path, std::vector<Dataset>& datasets) {
  constexpr hsize_t most = 64;
  for (hsize_t k = 0; k < most; ++k) {
    const Handle attribute(H5Aopen_by_idx(object, ".", H5_INDEX_NAME, H5_ITER_INC, k, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    if (!attribute.good()) return;
    std::array<char, 64> name{};
    const Handle type(H5Aget_type(attribute), H5Tclose), space(H5Aget_space(attribute), H5Sclose);
    const Handle native(type.good() ? H5Tget_native_type(type, H5T_DIR_ASCEND) : -1, H5Tclose);
    if (H5Aget_name(attribute, name.size(), name.data()) <= 0 || !names_rate(name.data()) || !native.good() || !space.good()) continue;
    const auto number = plain_type(native);
    if (!number || H5Sget_simple_extent_npoints(space) != 1) continue;
    Dataset& rate = datasets.emplace_back();
    rate.path = path.empty() ? "/" : path, rate.attribute = name.data();
    rate.array.name = path + "/" + rate.attribute, rate.array.rows = 1, rate.array.columns = {{rate.array.name}};
    rate.fields = {{*number, 0}}, rate.element = H5Tget_size(native);
  }
}

/// Sends it.
void send_rate(const OpenedFile& file, const Dataset& rate, const SendRows& send) {
  const Handle attribute(H5Aopen_by_name(file.file, rate.path.c_str(), rate.attribute.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  const Handle type(H5Aget_type(attribute), H5Tclose), native(H5Tget_native_type(type, H5T_DIR_ASCEND), H5Tclose);
  std::string buffer(rate.element, '\0');
  if (!native.good() || H5Tget_size(native) != rate.element || H5Aread(attribute, native, buffer.data()) < 0)
    throw Error(fmt::format("{}: {}: cannot be read; expected a number", file.name, rate.array.name));
  send_rows(rate.fields, buffer.data(), rate.element, 1, send);
}

herr_t add_name(hid_t, const char* name, const H5O_info_t* info, void* names) {
  if (info->type == H5O_TYPE_DATASET) static_cast<std::vector<std::string>*>(names)->push_back(name);
  return 0;
}

std::vector<Dataset> datasets_of(const OpenedFile& file) {
  std::vector<std::string> names;
  if (H5Ovisit(file.file, H5_INDEX_NAME, H5_ITER_INC, add_name, &names) < 0)
    throw Error(file.name + ": its groups are damaged; expected an HDF5 file");
  std::vector<Dataset> datasets;
  for (const std::string& name : names) {
    const Handle id(H5Dopen2(file.file, name.c_str(), H5P_DEFAULT), H5Dclose);
    if (!id.good()) throw Error(fmt::format("{}: /{}: is damaged; expected a dataset", file.name, name));
    if (file.matlab && !is_matlab_matrix(id, "/" + name)) continue;
    Dataset dataset = describe_dataset(file, id, "/" + name);
    if (!dataset.array.columns.empty()) datasets.push_back(std::move(dataset));
    add_rates(id, "/" + name, datasets);
  }
  add_rates(file.file, "", datasets);
  return datasets;
}

std::vector<NumberArray> arrays_of(const std::vector<Dataset>& datasets) {
  std::vector<NumberArray> arrays;
  for (const Dataset& dataset : datasets) arrays.push_back(dataset.array);
  return arrays;
}

/// Throws Error where chunks were never written: the library gives zeros for them.
void expect_all_chunks(hid_t dataset, hid_t properties, const std::string& place) {
  const Handle space(H5Dget_space(dataset), H5Sclose);
  constexpr int most = 2;  // dimensions, of what is read here
  std::array<hsize_t, most> size{}, chunk{};
  const int rank = H5Sget_simple_extent_ndims(space);
  hsize_t written = 0, all = 1;
  if (rank < 1 || rank > most || H5Sget_simple_extent_dims(space, size.data(), nullptr) != rank ||
      H5Pget_chunk(properties, most, chunk.data()) != rank || H5Dget_num_chunks(dataset, space, &written) < 0)
    throw Error(place + ": cannot be read; expected a whole dataset");
  for (std::size_t k = 0; k < static_cast<std::size_t>(rank); ++k) all *= (size[k] + chunk[k] - 1) / std::max<hsize_t>(1, chunk[k]);
  if (written < all)
    throw Error(fmt::format("{}: {}; expected the numbers themselves in this file", place,
                            written == 0 ? "was never written" : "was written in part, and the rest would be read as zeros"));
}

/// Where the numbers are, and by what they are packed. Throws Error for all that is not known to be read as it was written: the library gives zeros,
/// or fails without a reason, for numbers that are in other files, or nowhere.
void expect_known_storage(hid_t dataset, const std::string& place) {
  const auto fail = [&](const std::string& what) { throw Error(fmt::format("{}: {}; expected the numbers themselves in this file", place, what)); };
  const Handle properties(H5Dget_create_plist(dataset), H5Pclose);
  const H5D_layout_t layout = properties.good() ? H5Pget_layout(properties) : H5D_LAYOUT_ERROR;
  if (layout == H5D_VIRTUAL) fail("is a virtual dataset, whose numbers are in other files");
  if (layout != H5D_COMPACT && layout != H5D_CONTIGUOUS && layout != H5D_CHUNKED) fail("has a layout that is not known here");
  if (H5Pget_external_count(properties) != 0) fail("has its numbers in other files");
  static constexpr std::array<H5Z_filter_t, 6> known{H5Z_FILTER_DEFLATE, H5Z_FILTER_SHUFFLE, H5Z_FILTER_FLETCHER32,
                                                     H5Z_FILTER_SZIP,    H5Z_FILTER_NBIT,    H5Z_FILTER_SCALEOFFSET};
  for (unsigned i = 0; i < static_cast<unsigned>(std::max(0, H5Pget_nfilters(properties))); ++i) {
    std::array<char, 64> name{};
    std::size_t values = 0;
    unsigned flags = 0, config = 0;
    const H5Z_filter_t filter = H5Pget_filter2(properties, i, &flags, &values, nullptr, name.size() - 1, name.data(), &config);
    if (std::find(known.begin(), known.end(), filter) == known.end() || H5Zfilter_avail(filter) <= 0)
      fail(fmt::format("is packed by the filter {} ({}), which is not known here", static_cast<int>(filter), name.data()));
  }
  if (layout == H5D_CHUNKED) return expect_all_chunks(dataset, properties, place);
  H5D_space_status_t written = H5D_SPACE_STATUS_ERROR;
  if (H5Dget_space_status(dataset, &written) < 0 || written != H5D_SPACE_STATUS_ALLOCATED) fail("was never written");
}

/// Sends some columns of a dataset, some rows at a time.
void send_dataset(const OpenedFile& file, const Dataset& dataset, const std::vector<std::size_t>& wanted, const SendRows& send) {
  const auto fail = [&] { throw Error(fmt::format("{}: {}: cannot be read; expected a whole dataset", file.name, dataset.array.name)); };
  const Handle id(H5Dopen2(file.file, dataset.path.c_str(), H5P_DEFAULT), H5Dclose);
  const Handle type(H5Dget_type(id), H5Tclose), native(H5Tget_native_type(type, H5T_DIR_ASCEND), H5Tclose), space(H5Dget_space(id), H5Sclose);
  if (!native.good() || !space.good()) fail();
  expect_known_storage(id, fmt::format("{}: {}", file.name, dataset.array.name));
  const bool plane = dataset.dimensions.size() == 2;
  const auto [least, most] = std::minmax_element(wanted.begin(), wanted.end());
  const hsize_t first = plane ? *least : 0, columns = plane ? *most - *least + 1 : 1, rows = dataset.array.rows;
  const hsize_t at_once = std::min(rows, dataset.rows_at_once);
  std::vector<NumberField> fields;
  for (const std::size_t c : wanted) {
    const std::size_t place = static_cast<std::size_t>(dataset.lying ? at_once : 1) * dataset.element * (c - static_cast<std::size_t>(first));
    fields.push_back(plane ? NumberField{dataset.fields[0].type, place} : dataset.fields[c]);
  }
  std::string buffer(static_cast<std::size_t>(at_once * columns) * dataset.element, '\0');
  for (hsize_t row = 0; row < rows; row += at_once) {
    const hsize_t count = std::min(at_once, rows - row);
    // In memory a last piece stands where a full one would.
    const std::array<hsize_t, 2> begin = dataset.lying ? std::array{first, row} : std::array{row, first};
    const std::array<hsize_t, 2> size = dataset.lying ? std::array{columns, count} : std::array{count, columns};
    const std::array<hsize_t, 2> room = dataset.lying ? std::array{columns, at_once} : std::array{at_once, columns};
    const std::array<hsize_t, 2> zero{0, 0};
    const Handle memory(H5Screate_simple(plane ? 2 : 1, room.data(), nullptr), H5Sclose);
    const bool alone = H5Sget_simple_extent_type(space) == H5S_SCALAR;
    if ((!alone && H5Sselect_hyperslab(space, H5S_SELECT_SET, begin.data(), nullptr, size.data(), nullptr) < 0) ||
        H5Sselect_hyperslab(memory, H5S_SELECT_SET, zero.data(), nullptr, size.data(), nullptr) < 0 ||
        H5Dread(id, native, memory, space, H5P_DEFAULT, buffer.data()) < 0)
      fail();
    send_rows(fields, buffer.data(), dataset.element * static_cast<std::size_t>(dataset.lying ? 1 : columns), static_cast<std::size_t>(count), send);
  }
}

}  // namespace

void answer_hdf5(const ReadRequest& request, ToParent& to) {
  const OpenedFile file = open_hdf5(request.task.file);
  close_sandbox(request.task.file);
  const std::vector<Dataset> datasets = datasets_of(file);
  if (request.describes) return send_tables(to, descriptions_of(arrays_of(datasets)));
  const SendColumn send = column_sender(to);
  const std::vector<ArrayColumn> places = find_array_columns(arrays_of(datasets), request.topic, request.columns, file.name);
  for_each_array(places, datasets.size(), [&](std::size_t a, const std::vector<std::size_t>& chosen, const std::vector<std::size_t>& own) {
    const SendRows rows{send, own, datasets[a].array.rows};
    if (datasets[a].attribute.empty()) return send_dataset(file, datasets[a], chosen, rows);
    send_rate(file, datasets[a], rows);
  });
}

}  // namespace imulab::recording_io
