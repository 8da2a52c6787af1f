#include "imulab/formats/text/csv_field.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace imulab::text {
namespace {

struct FieldCase {
  std::string text, field;
};

TEST(CsvField, IsOneCellThatNothingRuns) {
  for (const FieldCase& c : std::vector<FieldCase>{
           {"012", "012"},
           {"", ""},
           {"Müller", "Müller"},
           {"a,b", "\"a,b\""},
           {"a;b", "\"a;b\""},
           {"say \"a\"", "\"say \"\"a\"\"\""},
           {"-12.5e-3", "-12.5e-3"},  // numbers stay numbers
           {"+5", "+5"},
           {"-5 units", "'-5 units"},
           {"--5", "'--5"},
           {"-", "'-"},
           {"=1+1", "'=1+1"},
           {"  =1+1", "'  =1+1"},
           {"=cmd|' /C calc'!A0,1", "\"'=cmd|' /C calc'!A0,1\""},
           {"+cmd", "'+cmd"},
           {"@SUM(A1)", "'@SUM(A1)"},
           {"\xef\xbc\x9d"
            "1",
            "'\xef\xbc\x9d"
            "1"},  // the wide =
           {"\t=1", "'\\x09=1"},
           {"\r=1", "'\\x0d=1"},
           {"a\nforged,row", "\"a\\x0aforged,row\""},
           {"\x1b[31m", "\\x1b[31m"},
           {"a\xe2\x80\xaez", "a\\xe2\\x80\\xaez"},
       })
    EXPECT_EQ(csv_field(c.text), c.field) << c.text;
}

}  // namespace
}  // namespace imulab::text
