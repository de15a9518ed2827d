#include "apps/common/built_in_models.h"

#include <string>

#include "gtest/gtest.h"
#include "mle/base/file.h"
#include "mle/model/process_model.h"

namespace mle {
namespace {

void ExpectIsItsFile(const BuiltInModel& model) {
  const std::string path = MLE_SOURCE_FOLDER "/" + std::string(model.source);
  const absl::StatusOr<std::string> file = ReadFile(path);
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_EQ(model.json, *file);
  const absl::StatusOr<ProcessModel> parsed =
      ParseProcessModel(model.json, model.source);
  EXPECT_TRUE(parsed.ok()) << parsed.status();
}

TEST(BuiltInModels, AreTheFilesInConfigs) {
  ExpectIsItsFile(kWoodBerry);
  for (const BuiltInModel& model : kWoodBerryAged) ExpectIsItsFile(model);
}

TEST(BuiltInModels, AgedColumnsDifferWhereThePaperSays) {
  const ProcessModel column =
      *ParseProcessModel(kWoodBerry.json, kWoodBerry.source);
  EXPECT_EQ(kWoodBerryAged[0].name, "gain");
  EXPECT_EQ(kWoodBerryAged[1].name, "delay");
  const double gain_change[2][2] = {{-6.4, 0.0}, {-3.3, 0.0}};
  const double delay_change[2][2] = {{0.0, 4.0}, {0.0, 4.0}};
  for (int number = 0; number < 2; ++number) {
    const BuiltInModel& model = kWoodBerryAged[number];
    const ProcessModel aged = *ParseProcessModel(model.json, model.source);
    EXPECT_TRUE(CheckSameChannels(column, "column", aged, "aged").ok());
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) {
        // Decimal fractions: differences are exact to rounding.
        EXPECT_NEAR(
            aged.element(i, j).StaticGain() - column.element(i, j).StaticGain(),
            number == 0 ? gain_change[i][j] : 0.0, 1e-13);
        EXPECT_EQ(aged.element(i, j).delay() - column.element(i, j).delay(),
                  number == 1 ? delay_change[i][j] : 0.0);
        EXPECT_EQ(aged.element(i, j).TimeConstant(),
                  column.element(i, j).TimeConstant());
      }
    }
  }
}

}  // namespace
}  // namespace mle
