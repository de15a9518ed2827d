#include "mle/exchange/model_conversion.h"

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/file.h"
#include "tests/mle/base/scratch_folder.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

constexpr double kExact = 1e-9;
constexpr double kInterval = 1.0;

const std::vector<ModelForm>& Forms() {
  static const auto* const forms = new std::vector<ModelForm>{
      ModelForm::kTransferFunctions, ModelForm::kElementTable,
      ModelForm::kStepResponses, ModelForm::kDiscreteTransferFunctions,
      ModelForm::kStateSpace};
  return *forms;
}

ModelFile Read(const std::string& name) {
  const absl::StatusOr<ModelFile> file =
      ReadModelFile(std::string(MLE_SOURCE_FOLDER "/configs/") + name);
  EXPECT_TRUE(file.ok()) << file.status();
  return file.ok() ? *file : ModelFile();
}

ModelConversion To(ModelForm form) {
  ModelConversion to;
  to.form = form;
  to.interval = kInterval;
  if (form == ModelForm::kElementTable) to.type = ModelFileType::kCsv;
  return to;
}

ConvertedModel Converted(const ModelFile& file, const ModelConversion& to) {
  const absl::StatusOr<ConvertedModel> converted = ConvertModel(file, to);
  EXPECT_TRUE(converted.ok()) << converted.status();
  return converted.ok() ? *converted : ConvertedModel();
}

ModelFile Reread(const ConvertedModel& converted) {
  const absl::StatusOr<ModelFile> file =
      ParseModelFile(converted.text, "converted");
  EXPECT_TRUE(file.ok()) << file.status();
  return file.ok() ? *file : ModelFile();
}

// "0.2 %", "exact" of the table in docs/formats.md, row by row.
std::vector<std::vector<double>> DocumentedTable() {
  const absl::StatusOr<std::string> text =
      ReadFile(MLE_SOURCE_FOLDER "/docs/formats.md");
  std::vector<std::vector<double>> rows;
  bool inside = false;
  for (const absl::string_view line : absl::StrSplit(*text, '\n')) {
    if (line.substr(0, 13) == "| from \\ to |") inside = true;
    if (line.empty()) inside = false;
    if (!inside || line.substr(0, 7) == "| from " || line[1] == '-') continue;
    rows.emplace_back();
    const std::vector<std::string> cells = absl::StrSplit(line, '|');
    for (std::size_t c = 2; c + 1 < cells.size(); ++c) {
      double percent = 0.0;
      const std::string number = cells[c].substr(0, cells[c].find('%'));
      if (!absl::SimpleAtod(number, &percent)) percent = 100.0 * kExact;
      rows.back().push_back(percent / 100.0);
    }
  }
  return rows;
}

TEST(ModelConversion, TheDocumentedErrorsAreThoseOfTheForms) {
  const std::vector<std::vector<double>> table = DocumentedTable();
  ASSERT_EQ(table.size(), Forms().size());
  const ModelFile shapes = Read("shapes.json");
  for (std::size_t from = 0; from < Forms().size(); ++from) {
    const ModelFile given = Reread(Converted(shapes, To(Forms()[from])));
    ASSERT_EQ(given.form, Forms()[from]);
    ASSERT_EQ(table[from].size(), Forms().size());
    for (std::size_t to = 0; to < Forms().size(); ++to) {
      const double largest =
          Converted(given, To(Forms()[to])).differences.maxCoeff();
      EXPECT_LE(largest, table[from][to])
          << NameOf(Forms()[from]) << " to " << NameOf(Forms()[to]);
      if (table[from][to] > kExact) {
        EXPECT_GT(largest, 0.1 * table[from][to])
            << NameOf(Forms()[from]) << " to " << NameOf(Forms()[to]);
      }
    }
  }
}

// What is stated is no less than what is found between the elements read back
// and those of the file, their own description aside.
TEST(ModelConversion, NoStepResponseIsFurtherOffThanStated) {
  for (const char* name : {"column_level.json", "shapes.json", "splitter.csv",
                           "wood_berry.csv", "heater_z.json"}) {
    const ModelFile given = Read(name);
    for (const ModelForm form : Forms()) {
      const ConvertedModel converted = Converted(given, To(form));
      const ModelFile again = Reread(converted);
      Eigen::MatrixXd allowed = converted.differences;
      for (const PairDescription& pair : again.descriptions) {
        allowed(pair.output, pair.input) += pair.largest_difference;
      }
      const ProcessModel& process = given.process;
      // Over the time, and at the interval, of its description.
      const bool sampled = !again.descriptions.empty();
      const double interval = sampled ? again.step_responses.interval : 1.0;
      const int samples = sampled ? again.step_responses.length() + 1 : 200;
      for (int i = 0; i < process.num_outputs(); ++i) {
        for (int j = 0; j < process.num_inputs(); ++j) {
          const Eigen::VectorXd wanted =
              process.element(i, j).StepResponse(interval, samples);
          const Eigen::VectorXd found =
              again.process.element(i, j).StepResponse(interval, samples);
          EXPECT_LE((found - wanted).cwiseAbs().maxCoeff(),
                    (allowed(i, j) + kExact) * RangeOf(wanted))
              << name << " to " << NameOf(form) << ": " << i << j;
        }
      }
    }
  }
}

// The type of file makes no difference: ramps too come back bit by bit.
TEST(ModelConversion, StepResponsesAreTheSameInEveryTypeOfFile) {
  ModelConversion to = To(ModelForm::kStepResponses);
  to.coefficients = 80;
  const ModelFile steps = Reread(Converted(Read("column_level.json"), to));
  EXPECT_EQ(steps.step_responses.length(), 80);
  const ScratchFolder folder;
  int ramps = 0;
  for (const ModelFileType type :
       {ModelFileType::kJson, ModelFileType::kCsv, ModelFileType::kMat}) {
    to.type = type;
    const ConvertedModel converted = Converted(steps, to);
    EXPECT_EQ(converted.differences.maxCoeff(), 0.0);
    const absl::StatusOr<ModelFile> again =
        ReadModelFile(folder.Write("steps", converted.text));
    ASSERT_TRUE(again.ok()) << again.status();
    // MAT files have all pairs, row by row, as the steps of a model have.
    ASSERT_EQ(again->step_responses.pairs.size(),
              steps.step_responses.pairs.size());
    for (std::size_t p = 0; p < steps.step_responses.pairs.size(); ++p) {
      const PairResponse& one = steps.step_responses.pairs[p];
      const PairResponse& other = again->step_responses.pairs[p];
      EXPECT_EQ(other.output, one.output);
      EXPECT_EQ(other.input, one.input);
      EXPECT_EQ(other.is_ramp, one.is_ramp);
      EXPECT_EQ(other.coefficients, one.coefficients);
      ramps += one.is_ramp ? 1 : 0;
    }
  }
  EXPECT_EQ(ramps, 3 * 3);
}

// The same model is what it was, to the bit, and transfer functions come back
// from MAT files.
TEST(ModelConversion, TheSameFormIsTheSameFile) {
  const ModelFile column = Read("column_level.json");
  for (const ModelForm form : Forms()) {
    const ConvertedModel first = Converted(column, To(form));
    const ConvertedModel second = Converted(Reread(first), To(form));
    EXPECT_EQ(second.text, first.text) << NameOf(form);
    EXPECT_EQ(second.differences.maxCoeff(), 0.0);
  }
  ModelConversion mat = To(ModelForm::kTransferFunctions);
  mat.type = ModelFileType::kMat;
  const ScratchFolder folder;
  const absl::StatusOr<ModelFile> again =
      ReadModelFile(folder.Write("column.mat", Converted(column, mat).text));
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(FormatProcessModel(again->process),
            FormatProcessModel(column.process));
}

TEST(ModelConversion, StepResponsesThatDoNotMoveAreRefused) {
  ModelFile file;
  file.process = ProcessModel("tank", "min", {{"steam", ""}}, {{"level", ""}});
  ModelConversion to = To(ModelForm::kStepResponses);
  to.coefficients = 20;
  const auto refusal = [&] {
    return std::string(ConvertModel(file, to).status().message());
  };
  EXPECT_THAT(refusal(), HasSubstr("the model has no elements"));
  file.process.element(0, 0) = TransferFunction::FirstOrder(2.0, 5.0, 30.0);
  EXPECT_THAT(refusal(), HasSubstr("no output moves within 20 coefficients"));
  to.coefficients = 40;
  EXPECT_TRUE(ConvertModel(file, to).ok());
}

// A bump that is 5 % of the whole range is more of the beginning's: what is cut
// short is near no transfer function any more.
TEST(ModelConversion, StepResponsesCutShortMustBeReadAgain) {
  ModelFile slow;
  slow.process = ProcessModel("tank", "min", {{"steam", ""}}, {{"level", ""}});
  slow.process.element(0, 0) = TransferFunction::FirstOrder(1.0, 60.0, 0.0);
  ModelConversion to = To(ModelForm::kStepResponses);
  to.coefficients = 240;
  ModelFile file = Reread(Converted(slow, to));
  ASSERT_EQ(file.step_responses.length(), 240);
  file.step_responses.pairs[0].coefficients.segment(5, 3).array() += 0.03;
  to.coefficients = 120;
  Reread(Converted(file, to));
  to.coefficients = 15;
  for (const ModelFileType type : {ModelFileType::kJson, ModelFileType::kMat}) {
    to.type = type;
    const absl::Status refused = ConvertModel(file, to).status();
    EXPECT_EQ(refused.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(
        std::string(refused.message()),
        testing::AllOf(HasSubstr("every 1 min, could not be read again: "),
                       HasSubstr("level ← steam: its step response has not")));
  }
}

// Five lags of one time constant have passed 56 % of the way after five.
TEST(ModelConversion, ManyEqualLagsAreSampledUntilTheyHaveSettled) {
  ModelFile file;
  file.process = ProcessModel("tank", "min", {{"steam", ""}}, {{"level", ""}});
  file.process.element(0, 0) =
      TransferFunction({2.0}, {1.0, 5.0, 10.0, 10.0, 5.0, 1.0}, 0.0);
  const ModelFile sampled =
      Reread(Converted(file, To(ModelForm::kStepResponses)));
  const Eigen::VectorXd& c = sampled.step_responses.pairs[0].coefficients;
  EXPECT_NEAR(c(c.size() - 1), 2.0, 0.02);
  EXPECT_NEAR(sampled.process.element(0, 0).StaticGain(), 2.0, 0.03);
  const ModelFile table = Reread(Converted(file, To(ModelForm::kElementTable)));
  EXPECT_NEAR(table.process.element(0, 0).StaticGain(), 2.0, 0.1);
}

TEST(ModelConversion, NamesThatAFormDoesNotKeepAreRefused) {
  ModelFile file;
  file.process = ProcessModel("tank", "min", {{"b/c", ""}, {"c", ""}},
                              {{"a", ""}, {"a/b", ""}});
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      file.process.element(i, j) = TransferFunction::FirstOrder(1.0, 5.0, 1.0);
    }
  }
  const auto refusal = [&](ModelForm form) {
    ModelConversion to = To(form);
    to.type = ModelFileType::kCsv;
    return std::string(ConvertModel(file, to).status().message());
  };
  EXPECT_THAT(refusal(ModelForm::kStepResponses),
              HasSubstr("could not be read again"));
  EXPECT_EQ(refusal(ModelForm::kElementTable), "");
  file.process = ProcessModel("tank", "min", {{" steam", ""}}, {{"level", ""}});
  file.process.element(0, 0) = TransferFunction::FirstOrder(1.0, 5.0, 1.0);
  EXPECT_THAT(refusal(ModelForm::kElementTable),
              HasSubstr("names or units of channels would be others"));
}

// Noisy coefficients whose transfer function, sampled, is none of those that
// are tried for sampled models.
TEST(ModelConversion, SampledModelsMustBeReadAgain) {
  const absl::StatusOr<ModelFile> noisy = ReadModelFile(
      MLE_SOURCE_FOLDER "/tests/fuzz/corpus/model_file/truncated_steps.json");
  ASSERT_TRUE(noisy.ok()) << noisy.status();
  for (const ModelForm form :
       {ModelForm::kDiscreteTransferFunctions, ModelForm::kStateSpace}) {
    const absl::Status refused = ConvertModel(*noisy, To(form)).status();
    EXPECT_EQ(refused.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(refused.message()),
                HasSubstr("could not be read again: no transfer function"));
  }
}

// A file of it would not be read again.
TEST(ModelConversion, NoOtherFormWithoutElements) {
  ModelFile file;
  file.process = ProcessModel("tank", "min", {{"steam", ""}}, {{"level", ""}});
  file.process.element(0, 0) = TransferFunction::FirstOrder(0.0, 5.0, 2.5);
  EXPECT_TRUE(ConvertModel(file, To(ModelForm::kTransferFunctions)).ok());
  ModelConversion table = To(ModelForm::kElementTable);
  table.type = ModelFileType::kCsv;
  for (const ModelConversion& to : {table, To(ModelForm::kStepResponses),
                                    To(ModelForm::kDiscreteTransferFunctions),
                                    To(ModelForm::kStateSpace)}) {
    EXPECT_THAT(std::string(ConvertModel(file, to).status().message()),
                HasSubstr("the model has no elements"));
  }
}

TEST(ModelConversion, NoTableWithoutATimeUnit) {
  ModelFile file;
  file.process = ProcessModel("tank", " ", {{"steam", ""}}, {{"level", ""}});
  file.process.element(0, 0) = TransferFunction::FirstOrder(2.0, 5.0, 2.5);
  for (const ModelForm form :
       {ModelForm::kElementTable, ModelForm::kStepResponses}) {
    ModelConversion to = To(form);
    to.type = ModelFileType::kCsv;
    EXPECT_THAT(std::string(ConvertModel(file, to).status().message()),
                HasSubstr("the model has no time unit"));
  }
  EXPECT_TRUE(ConvertModel(file, To(ModelForm::kStepResponses)).ok());
}

TEST(ModelConversion, SaysWhatDoesNotFit) {
  ModelConversion to = To(ModelForm::kStateSpace);
  to.type = ModelFileType::kCsv;
  EXPECT_THAT(std::string(to.Validate().message()),
              HasSubstr("form=state_space: a file of this type"));
  to = To(ModelForm::kStepResponses);
  to.coefficients = 9;
  EXPECT_THAT(std::string(to.Validate().message()),
              HasSubstr("coefficients=9"));
  to = To(ModelForm::kStateSpace);
  to.tolerance = 0.0;
  EXPECT_THAT(std::string(to.Validate().message()), HasSubstr("tolerance=0"));
  to = To(ModelForm::kStateSpace);
  to.interval = -1.0;
  EXPECT_THAT(std::string(to.Validate().message()), HasSubstr("interval=-1"));
  EXPECT_FALSE(ModelFormOf("arx").has_value());
  EXPECT_EQ(ModelFormOf("state_space"), ModelForm::kStateSpace);
}

}  // namespace
}  // namespace mle
