// Files that go away, or change, between the look at their form and the
// reading.

#include <algorithm>
#include <cstddef>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/data/historian.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

ProcessModel VanishingTank() {
  return ProcessModel("tank", "min", {{"inflow", ""}}, {{"level", ""}});
}

// 200 rows with a step of the set point at row 100.
std::string Export() {
  std::string text = "time,level,level_setpoint,inflow\n";
  for (int k = 0; k < 200; ++k) {
    absl::StrAppend(&text, k, ",", k % 3, ",", k >= 100 ? 1 : 0, ",1\n");
  }
  return text;
}

// What each opening in turn finds: a text, or, where it is empty, no file.
HistorianSource Changing(std::vector<std::string> texts) {
  auto opened = std::make_shared<std::size_t>(0);
  return {"live.csv",
          [texts = std::move(texts),
           opened]() -> absl::StatusOr<std::unique_ptr<std::istream>> {
            const std::size_t i = std::min((*opened)++, texts.size() - 1);
            if (texts[i].empty()) {
              return absl::NotFoundError("cannot open 'live.csv'");
            }
            return std::make_unique<std::istringstream>(texts[i]);
          }};
}

absl::StatusOr<HistorianImport> ImportVanishing(const HistorianSource& source) {
  return ImportHistorianSources({source}, VanishingTank(), HistorianOptions());
}

TEST(VanishingFileTest, IsReadWhereItStays) {
  const auto import = ImportVanishing(Changing({Export()}));
  ASSERT_TRUE(import.ok()) << import.status();
  ASSERT_EQ(import->records.size(), 1u);
  EXPECT_EQ(import->records[0].samples(), 200);
}

// However many openings there are, any of them may be the one that fails.
TEST(VanishingFileTest, IsNamedWhenItIsGone) {
  int failures = 0;
  for (int stays = 0; stays < 5; ++stays) {
    std::vector<std::string> texts(stays, Export());
    texts.push_back("");
    const auto import = ImportVanishing(Changing(texts));
    if (import.ok()) break;
    ++failures;
    EXPECT_TRUE(absl::IsNotFound(import.status())) << import.status();
    EXPECT_THAT(std::string(import.status().message()), HasSubstr("live.csv"));
  }
  EXPECT_GE(failures, 2);  // to look, and to read
}

TEST(VanishingFileTest, NeverMakesAnInvalidRecord) {
  for (const std::string& other :
       {std::string("time,level,inflow\n0,1,2\n1,1,2\n"),
        Export().substr(0, 40), std::string("<html>gone</html>\n")}) {
    const auto import = ImportVanishing(Changing({Export(), other}));
    if (import.ok()) {
      for (const Record& record : import->records) {
        EXPECT_TRUE(record.Validate().ok()) << record.Validate();
      }
    } else {
      EXPECT_THAT(std::string(import.status().message()),
                  HasSubstr("live.csv"));
    }
  }
}

}  // namespace
}  // namespace mle
