#include "mle/exchange/model_file.h"

#include <string>

#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/mle/exchange/step_response_texts.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

const std::string kConfigs = MLE_CONFIGS_FOLDER;

ModelFile ReadForm(const std::string& name) {
  const absl::StatusOr<ModelFile> file = ReadModelFile(kConfigs + "/" + name);
  EXPECT_TRUE(file.ok()) << file.status();
  return file.ok() ? *file : ModelFile();
}

TEST(ModelFile, TellsFormsApart) {
  EXPECT_EQ(ReadForm("wood_berry.json").form, ModelForm::kTransferFunctions);
  EXPECT_EQ(ReadForm("wood_berry.csv").form, ModelForm::kStepResponses);
  const absl::StatusOr<ModelFile> json = ParseModelFile(
      absl::StrReplaceAll(kTankJson, {{"\"ramp\"", "\"steady\""}}), "tank");
  ASSERT_TRUE(json.ok()) << json.status();
  EXPECT_EQ(json->form, ModelForm::kStepResponses);
  EXPECT_EQ(json->type, ModelFileType::kJson);
  EXPECT_EQ(CorrectedName(*json), "model_corrected.json");
  const absl::StatusOr<ModelFile> ramp = ParseModelFile(kTankJson, "tank.json");
  ASSERT_TRUE(ramp.ok()) << ramp.status();
  EXPECT_FALSE(ramp->process.element(0, 0).IsIntegrating());
  EXPECT_TRUE(ramp->process.element(0, 1).IsIntegrating());
  EXPECT_THAT(std::string(ParseModelFile("x", "a.json").status().message()),
              HasSubstr("a.json: line 1"));
  EXPECT_THAT(std::string(ReadModelFile("/no/a.csv").status().message()),
              HasSubstr("/no/a.csv"));
}

// The example is the splitter itself.
TEST(ModelFile, ReadsTablesOfElements) {
  const ModelFile table = ReadForm("splitter.csv");
  EXPECT_EQ(table.form, ModelForm::kElementTable);
  const ProcessModel wanted = ReadForm("splitter.json").process;
  ASSERT_TRUE(CheckSameChannels(table.process, "csv", wanted, "json").ok());
  for (int i = 0; i < wanted.num_outputs(); ++i) {
    for (int j = 0; j < wanted.num_inputs(); ++j) {
      EXPECT_EQ(table.process.element(i, j).StepResponse(1.0, 100),
                wanted.element(i, j).StepResponse(1.0, 100));
    }
  }
  ProcessModel other = table.process;
  other.element(0, 0) = TransferFunction({-1.8}, {80.0, 10.0, 1.0}, 4.0);
  const auto corrected = FormatCorrected(table, other);
  ASSERT_EQ(corrected->differences.size(), 1U);
  EXPECT_GT(corrected->differences[0].largest_difference, 0.05);
}

// The example is the column itself, sampled and rounded to six digits.
TEST(ModelFile, DescribesTheColumn) {
  const ModelFile column = ReadForm("wood_berry.json");
  const ModelFile sampled = ReadForm("wood_berry.csv");
  ASSERT_EQ(sampled.process.num_outputs(), 2);
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      const TransferFunction& wanted = column.process.element(i, j);
      const TransferFunction& found = sampled.process.element(i, j);
      ASSERT_TRUE(found.IsFirstOrder());
      EXPECT_NEAR(found.StaticGain(), wanted.StaticGain(), 1e-3);
      EXPECT_NEAR(found.TimeConstant(), wanted.TimeConstant(), 1e-3);
      EXPECT_NEAR(found.delay(), wanted.delay(), 1e-3);
    }
  }
  EXPECT_TRUE(NotableDifferences(sampled).empty());
}

// Without a change the file comes back; a changed pair alone has new numbers.
TEST(ModelFile, IsWrittenBackCorrected) {
  const ModelFile file = ReadForm("wood_berry.csv");
  EXPECT_EQ(CorrectedName(ReadForm("wood_berry.json")), "");
  const auto same = FormatCorrected(file, file.process);
  ASSERT_TRUE(same.ok());
  EXPECT_EQ(same->name, "model_corrected.csv");
  EXPECT_EQ(same->text, FormatStepResponseCsv(file.step_responses));
  ProcessModel halved = file.process;
  const TransferFunction& element = halved.element(1, 0);
  halved.element(1, 0) = TransferFunction::FirstOrder(
      0.5 * element.StaticGain(), element.TimeConstant(), element.delay());
  const auto corrected = FormatCorrected(file, halved);
  const absl::StatusOr<StepResponseModel> read =
      ParseStepResponseModel(corrected->text, corrected->name);
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->pairs.size(), 4U);
  EXPECT_EQ(read->interval, file.step_responses.interval);
  for (std::size_t p = 0; p < 4; ++p) {
    const PairResponse& before = file.step_responses.pairs[p];
    const PairResponse& after = read->pairs[p];
    if (after.output == 1 && after.input == 0) {
      // Half of what describes it: the description is that near.
      EXPECT_LT((after.coefficients - 0.5 * before.coefficients)
                    .cwiseAbs()
                    .maxCoeff(),
                1e-4);
    } else {
      EXPECT_EQ(after.coefficients, before.coefficients);
    }
  }
}

}  // namespace
}  // namespace mle
