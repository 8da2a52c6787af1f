#include "imulab/formats/text/printable.hpp"

#include <gtest/gtest.h>

#include <string>

namespace imulab {
namespace {

TEST(Printable, KeepsTextAndShowsWhatSteers) {
  for (const char* text : {"", "plain, with\ttabs\nand lines\n", "µ ² ± → 漢字 😀 ﬁ"}) EXPECT_EQ(printable(text), text);
  EXPECT_EQ(printable(std::string("\0\x1b[31m\r\x7f", 8)), "\\x00\\x1b[31m\\x0d\\x7f");
  EXPECT_EQ(printable("\xc2\x9b"
                      "31m"),
            "\\xc2\\x9b31m");  // CSI of the set C1
  EXPECT_EQ(printable("\xe2\x80\xae"
                      "x"),
            "\\xe2\\x80\\xaex");  // from right to left
  EXPECT_EQ(printable("\xff"
                      "a\xc3"),
            "\\xffa\\xc3");                                                                     // no UTF-8, and cut
  EXPECT_EQ(printable("\xc0\x9b\xe0\x80\x9b"), "\\xc0\\x9b\\xe0\\x80\\x9b");                    // a control in more bytes than it needs
  EXPECT_EQ(printable("\xed\xa0\x80\xf4\x90\x80\x80"), "\\xed\\xa0\\x80\\xf4\\x90\\x80\\x80");  // a surrogate, and beyond Unicode
}

TEST(Printable, ANameIsOneLineAndWhole) {
  EXPECT_EQ(one_line("a\nb\tc"), "a\\x0ab\\x09c");
  EXPECT_EQ(one_line(std::string(100, 'x')), std::string(100, 'x'));
}

TEST(Printable, EscapesMeanTheSame) {  // U+202E, U+009B, and what needs none
  EXPECT_EQ(with_escapes("\xe2\x80\xae|\xc2\x9b|\xc2\xb5|\n\xff"), "\\u202E|\\u009B|\xc2\xb5|\n\xff");
}

TEST(Printable, AnExcerptIsOneShortLine) {
  EXPECT_EQ(excerpt("two\nlines"), "two\\x0alines");
  EXPECT_EQ(excerpt(std::string(60, 'a')), std::string(60, 'a'));
  EXPECT_EQ(excerpt(std::string(20'000'000, 'a')), std::string(60, 'a') + "...");
  EXPECT_EQ(excerpt("µµµµ", 3), "µµµ...");
}

}  // namespace
}  // namespace imulab
