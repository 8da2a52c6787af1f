// Files that NumPy wrote (tests/recordings/numpy_files.py).
#include <gmock/gmock.h>

#include "tests/recording_files.hpp"
#include <array>
#include <cmath>

namespace imulab {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

double row_value(std::size_t i, std::size_t c) { return c == 0 ? fixture_t(i) : c < 4 ? fixture_gyro(i, c - 1) : fixture_accel(i, c - 4); }

TEST(NumPy, RowsInAnyOrderAndByteOrder) {
  const std::vector<Column> all{1, 2, 3, 4, 5, 6, 7};
  for (const char* name : {"rows.npy", "rows_fortran.npy", "lying.npy"}) {
    expect_columns({.file = recording_file(name)}, all, row_value);
    expect_columns({.file = recording_file(name)}, {"5", 1, 1}, [](std::size_t i, std::size_t c) { return row_value(i, c == 0 ? 4 : 0); });
  }
  expect_columns({.file = recording_file("rows_f4_big.npy")}, {2, 3, 4, 5, 6, 7}, [](std::size_t i, std::size_t c) { return row_value(i, c + 1); });
}

TEST(NumPy, StampsStayExact) {
  const auto table = columns_of({.file = recording_file("stamps.npy")}, {1});
  ASSERT_EQ(table.columns[0].integers.size(), fixture_samples);
  for (std::size_t i = 0; i < fixture_samples; ++i) EXPECT_EQ(table.columns[0].integers[i], fixture_ns(i));
}

TEST(NumPy, FieldsAreColumns) {
  const TableRequest request{.file = recording_file("fields.npy")};
  const auto tables = format_of(request).describe(request);
  ASSERT_EQ(tables.size(), 1u);
  EXPECT_EQ(tables[0].rows, fixture_samples);
  EXPECT_THAT(column_texts(tables[0]), ElementsAre("stamp", "gyro.1", "gyro.2", "gyro.3", "imu.ax", "imu.ay", "imu.az"));
  expect_columns(request, {"gyro.1", "gyro.2", "gyro.3"}, fixture_gyro);
  expect_columns(request, {"imu.ax", "imu.ay", "imu.az"}, fixture_accel);
  EXPECT_EQ(columns_of(request, {"stamp"}).columns[0].integers[7], fixture_ns(7));
}

TEST(NumPy, ArraysOfOneLengthAreOneTable) {
  for (const char* name : {"arrays.npz", "arrays_deflated.npz"}) {
    const TableRequest request{.file = recording_file(name)};
    const auto tables = format_of(request).describe(request);
    ASSERT_EQ(tables.size(), 1u) << name;
    EXPECT_EQ(tables[0].name, "");
    EXPECT_THAT(column_texts(tables[0]), ElementsAre("gyro.1", "gyro.2", "gyro.3", "accel.1", "accel.2", "accel.3", "stamp", "time [ns]", "counts.1",
                                                     "counts.2", "counts.3", "flags"));
    expect_columns(request, {"gyro.1", "gyro.2", "gyro.3"}, fixture_gyro);
    expect_columns(request, {"accel.1", "accel.2", "accel.3"}, fixture_accel);
    expect_columns(request, {"counts.1", "counts.2", "counts.3"}, fixture_counts);
    expect_columns(request, {"flags"}, [](std::size_t i, std::size_t) { return i % 2 == 0 ? 1.0 : 0.0; });
    EXPECT_EQ(columns_of(request, {"stamp"}).columns[0].integers[39], fixture_ns(39));
    EXPECT_EQ(columns_of(request, {"time"}).columns[0].integers[39], fixture_ns(39));
    expect_columns(request, {"accel.3", "gyro.1", "accel.3"},
                   [](std::size_t i, std::size_t c) { return c == 1 ? fixture_gyro(i, 0) : fixture_accel(i, 2); });
  }
}

TEST(NumPy, AnyArrayNamesItsTable) {
  TableRequest request{.file = recording_file("two_lengths.npz")};
  EXPECT_THAT(error_of(request, {"gyro.1"}), HasSubstr("has several topics and the session names none; expected topic = one of gyro_t, accel_t"));
  request.topic = "accel";
  expect_columns(request, {"accel.1", "accel.2", "accel.3"}, fixture_accel, 37);
  EXPECT_THAT(error_of(request, {"gyro.1"}), HasSubstr("two_lengths.npz: accel_t: column gyro.1 is not there; expected one of accel_t, accel.1"));
  request.topic = "gyro_t";
  expect_columns(request, {"gyro.1", "gyro.2", "gyro.3"}, fixture_gyro);
  request.topic = "mag";
  EXPECT_THAT(error_of(request, {"gyro.1"}), HasSubstr("two_lengths.npz: topic mag is not there; expected one of gyro_t, accel_t"));
}

TEST(NumPy, ReadsAsARecording) {
  const auto table = recording_io::read_table({.file = recording_file("arrays_deflated.npz")},
                                              {.columns = {"gyro.1"}, .time = {.column = "stamp", .unit = "ns", .zero = fixture_ns(0)}});
  EXPECT_EQ(table.time_ns[1], 8'000'000);
  EXPECT_EQ(table.columns[0].numbers[1], fixture_gyro(1, 0));
}

TEST(NumPy, ACutFileIsReadWithAWarning) {
  const TemporaryFolder folder;
  const std::string bytes = file_bytes(recording_file("rows.npy"));
  const TableRequest request{.file = folder.write("cut.npy", bytes.substr(0, bytes.size() - 60))};
  const auto table = columns_of(request, {1});
  EXPECT_EQ(table.columns[0].size(), 38u);  // 60 bytes are two rows of 56, the second in part
  EXPECT_THAT(table.warnings, ElementsAre(HasSubstr("cut.npy: ends after 38 of 40 rows: the others are lost")));
}

TEST(NumPy, WrongHeadsAreErrors) {
  const TemporaryFolder folder;
  const std::string ones(64, '\1');
  const auto beyond = [](const char* message) { return sizeof(std::size_t) == 4 ? "larger than any file" : message; };  // 2 GiB
  const struct {
    std::string bytes, message;
  } cases[] = {
      {npy_file("{'descr': '<f8', 'fortran_order': False, 'shape': (100000000, 100000000), }", ones), beyond("has less than a row of numbers")},
      {npy_file("{'descr': '<f8', 'fortran_order': True, 'shape': (1000000000, 7), }", ones), beyond("ends after 64 of 56000000000 bytes")},
      {npy_file("{'descr': '<f8', 'fortran_order': False, 'shape': (4000000000, 4000000000, 4000000000), }", ones), "larger than any file"},
      {npy_file("{'descr': [('a', '<f8', (65000,65000))], 'fortran_order': False, 'shape': (1,), }", ones),
       beyond("field a has 4225000000 elements")},
      {npy_file("{'descr': '|O', 'fortran_order': False, 'shape': (4,), }", ones), "an array of |O, empty or of more than two dimensions"},
      {npy_file("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2, 2), }", ones), "of more than two dimensions"},
      {npy_file("{'descr': '<f8', 'fortran_order': False, 'shape': (4", ones), "the head ends too early"},
      {npy_file("{'descr': '<f8', 'shape': (4,)}", ones), "the head has no fortran_order"},
      {npy_file(std::string(300, '('), ones), "nested too deep"},
      {npy_file("{'descr': 'f', 'fortran_order': False, 'shape': (4,), }", ones), "f is not a type"},
      {npy_file("", "").substr(0, 11), "its head is damaged"},
      {std::string("PK\3\4", 4) + std::string(60, '\0'), "has no directory at its end"},
  };
  for (const auto& c : cases) EXPECT_THAT(error_of({.file = folder.write("x.npy", c.bytes)}, {1}), HasSubstr("x.npy: ")) << c.message;
  for (const auto& c : cases) EXPECT_THAT(error_of({.file = folder.write("x.npy", c.bytes)}, {1}), HasSubstr(c.message));
}

TEST(NumPy, RowsAreCheckedAsThoseOfText) {
  using Row = std::array<double, 2>;  // a stamp and a reading
  const TemporaryFolder folder;
  const auto read = [&](const std::vector<Row>& rows) {
    const std::string head = "{'descr': '<f8', 'fortran_order': False, 'shape': (" + std::to_string(rows.size()) + ", 2), }";
    const std::string data(reinterpret_cast<const char*>(rows.data()), rows.size() * sizeof(Row));
    return recording_io::read_table({.file = folder.write("rows.npy", npy_file(head, data))},
                                    {.columns = {2}, .time = {.column = 1}, .rate_hz = std::nullopt});
  };
  const recording_io::TableRows table = read({{0.01, 1}, {0.02, 2}, {0.02, 2}, {0.03, 3}});
  EXPECT_THAT(table.time_ns, ElementsAre(10'000'000, 20'000'000, 30'000'000));
  ASSERT_EQ(table.columns.size(), 1u);
  EXPECT_THAT(table.columns[0].numbers, ElementsAre(1, 2, 3));
  EXPECT_EQ(table.repeated, 1u);
  const auto expect_error = [&](const std::vector<Row>& rows, const char* message) {
    EXPECT_THAT([&] { read(rows); }, ThrowsMessage<Error>(HasSubstr(message)));
  };
  expect_error({{0.01, 1}, {0.02, 2}, {0.02, 3}}, "rows.npy: row 3: 0.02 s is on two rows with different readings");
  expect_error({{0.01, 1}, {0.02, 2}, {0.01, 3}}, "rows.npy: row 3: time runs backwards: 0.01 s after 0.02 s");
  expect_error({{0.01, 1}, {0.02, std::nan("")}}, "rows.npy: row 2: column 2: nan is not a reading");
  expect_error({{0.01, 1}, {1e300, 2}}, "rows.npy: row 2: the stamp is not a time within 146 years");
}

TEST(NumPy, DamageIsSurvived) {
  for (const char* name : {"rows.npy", "rows_fortran.npy", "fields.npy"}) expect_damage_is_survived({.file = recording_file(name)}, {1}, 11);
  for (const char* name : {"arrays.npz", "arrays_deflated.npz"})
    expect_damage_is_survived({.file = recording_file(name)}, {"gyro.1", "counts.2"}, 17);
  expect_damage_is_survived({.file = recording_file("two_lengths.npz"), .topic = "gyro"}, {"gyro.1"}, 7);
}

TEST(NumPy, DamagedCompressedDataAreNotReadings) {
  const TemporaryFolder folder;
  std::string bytes = file_bytes(recording_file("arrays_deflated.npz"));
  const std::size_t at = bytes.find("accel.npy") - 70;
  bytes[at] = static_cast<char>(bytes[at] ^ 8);
  EXPECT_THAT(error_of({.file = folder.write("x.npz", bytes)}, {"gyro.1"}), testing::AnyOf(HasSubstr("damaged"), HasSubstr("too early")));
}

}  // namespace
}  // namespace imulab
