// The page of web/ asks no other server, and its scripts find what they look for; what it computes is tested in a browser (./dev accept portable
// wasm).
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>

namespace imulab {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsSupersetOf;
using ::testing::Not;

std::string text_of_web(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(fs::path(IMULAB_SOURCE) / "web" / file).rdbuf();
  return text.str();
}

std::set<std::string> found_in(const std::string& text, const char* pattern) {
  std::set<std::string> found;
  const std::regex expression(pattern);
  for (std::sregex_iterator at(text.begin(), text.end(), expression), end; at != end; ++at) found.insert((*at)[1]);
  return found;
}

TEST(WebPage, ItsScriptsFindTheElementsThatTheyUse) {
  const std::set<std::string> ids = found_in(text_of_web("page/index.html"), R"re(\bid="([^"]+)")re");
  for (const char* script : {"page/page.js", "page/live.js"}) {
    const std::set<std::string> used = found_in(text_of_web(script), R"re(\bat\("([^"]+)"\))re");
    EXPECT_THAT(used, Not(IsEmpty()));
    EXPECT_THAT(ids, IsSupersetOf(used)) << script;
  }
}

TEST(WebPage, AllowsItsOwnFilesAlone) {
  EXPECT_THAT(text_of_web("page/index.html"), HasSubstr("default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self';"));
  EXPECT_THAT(text_of_web("page/report.html"), HasSubstr("default-src 'none'; script-src 'unsafe-inline';"));
  for (const auto& entry : fs::directory_iterator(fs::path(IMULAB_SOURCE) / "web/page")) {
    const std::set<std::string> addresses = found_in(text_of_web("page" / entry.path().filename()), R"re((https?://[^"'\s]+))re");
    for (const std::string& address : addresses) EXPECT_EQ(address, "http://www.w3.org/2000/svg") << entry.path();  // a name, which nothing loads
  }
}

TEST(WebPage, PutsNoMarkupOfItsOwnMaking) {
  for (const auto& entry : fs::directory_iterator(fs::path(IMULAB_SOURCE) / "web/page"))
    EXPECT_THAT(found_in(text_of_web("page" / entry.path().filename()), R"re((innerHTML|outerHTML|insertAdjacentHTML|eval\())re"), IsEmpty())
        << entry.path();
}

}  // namespace
}  // namespace imulab
