#include "mle/exchange/mat_file.h"

#include <matio.h>

#include <cstdlib>
#include <fstream>
#include <string>
#include <variant>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/file.h"
#include "mle/exchange/mat_variables.h"
#include "mle/exchange/model_file.h"
#include "tests/mle/base/scratch_folder.h"

namespace mle {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

ProcessModel Tank() {
  ProcessModel model("Tank °1", "min",
                     {{"steam", "t/h"},
                      {"inflow", "m³/h", InputRole::kDisturbance},
                      {"air", ""}},
                     {{"temperature", "°C"}, {"pressure", "bar"}});
  model.element(0, 0) = TransferFunction::FirstOrder(8.0, 12.3, 1.5);
  model.element(0, 1) = TransferFunction({-0.1, 0.37}, {21.0, 10.0, 1.0}, 0.25);
  model.element(1, 2) = TransferFunction::FirstOrder(1.0 / 3.0, 7.0, 0.1);
  return model;
}

StepResponseModel TankSteps() {
  StepResponseModel model;
  const ProcessModel tank = Tank();
  model.channels = ProcessModel(tank.name(), tank.time_unit(), tank.inputs(),
                                tank.outputs());
  model.interval = 0.7;
  for (const auto& [i, j] :
       {std::pair(0, 0), std::pair(0, 1), std::pair(1, 2)}) {
    model.pairs.push_back(
        {i, j, tank.element(i, j).StepResponse(0.7, 41).tail(40), i == 1});
  }
  return model;
}

class MatFile : public ::testing::Test {
 protected:
  const ScratchFolder folder_;
};

void ExpectSameChannels(const ProcessModel& a, const ProcessModel& b) {
  EXPECT_TRUE(CheckSameChannels(a, "a", b, "b").ok())
      << CheckSameChannels(a, "a", b, "b");
  EXPECT_EQ(a.name(), b.name());
  for (int j = 0; j < a.num_inputs(); ++j) {
    EXPECT_EQ(a.inputs()[j].unit, b.inputs()[j].unit);
    EXPECT_EQ(a.inputs()[j].role, b.inputs()[j].role);
  }
  EXPECT_EQ(a.outputs()[0].unit, b.outputs()[0].unit);
}

TEST_F(MatFile, TransferFunctionsComeBackBitByBit) {
  const ProcessModel tank = Tank();
  const absl::StatusOr<std::string> bytes = FormatMat(tank);
  ASSERT_TRUE(bytes.ok()) << bytes.status();
  EXPECT_TRUE(IsMatFile(*bytes));
  EXPECT_EQ(*bytes, *FormatMat(tank));
  const absl::StatusOr<ModelFile> file =
      ReadModelFile(folder_.Write("tank.mat", *bytes));
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_EQ(file->form, ModelForm::kTransferFunctions);
  ExpectSameChannels(file->process, tank);
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 3; ++j) {
      EXPECT_EQ(file->process.element(i, j).numerator(),
                tank.element(i, j).numerator());
      EXPECT_EQ(file->process.element(i, j).denominator(),
                tank.element(i, j).denominator());
      EXPECT_EQ(file->process.element(i, j).delay(),
                tank.element(i, j).delay());
    }
  }
}

TEST_F(MatFile, StepResponsesComeBackBitByBit) {
  const StepResponseModel tank = TankSteps();
  const absl::StatusOr<MatModel> read =
      ReadMatModel(folder_.Write("steps.mat", *FormatMat(tank)));
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_TRUE(std::holds_alternative<StepResponseModel>(*read));
  const auto& steps = std::get<StepResponseModel>(*read);
  ExpectSameChannels(steps.channels, tank.channels);
  EXPECT_EQ(steps.interval, tank.interval);
  ASSERT_EQ(steps.pairs.size(), 3U);
  for (int p = 0; p < 3; ++p) {
    EXPECT_EQ(steps.pairs[p].output, tank.pairs[p].output);
    EXPECT_EQ(steps.pairs[p].input, tank.pairs[p].input);
    EXPECT_EQ(steps.pairs[p].is_ramp, tank.pairs[p].is_ramp);
    EXPECT_EQ(steps.pairs[p].coefficients, tank.pairs[p].coefficients);
  }
}

// A corrected model of step responses is a MAT file again.
TEST_F(MatFile, IsWrittenBackCorrected) {
  StepResponseModel tank = TankSteps();
  tank.pairs[2].is_ramp = false;
  const absl::StatusOr<ModelFile> file =
      ReadModelFile(folder_.Write("steps.mat", *FormatMat(tank)));
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_EQ(CorrectedName(*file), "model_corrected.mat");
  const auto same = FormatCorrected(*file, file->process);
  EXPECT_EQ(same->text, *FormatMat(tank));
}

TEST_F(MatFile, OctaveLoadsIt) {
  const std::string octave = MLE_OCTAVE;
  if (octave.empty()) GTEST_SKIP() << "there is no Octave";
  const std::string steps = folder_.Write("steps.mat", *FormatMat(TankSteps()));
  const std::string tank = folder_.Write("tank.mat", *FormatMat(Tank()));
  const std::string program = absl::StrCat(
      "load('", steps, "'); load('", tank,
      "'); assert(size(step_responses), [40 2 3]); assert(interval, 0.7); "
      "assert(inputs{2}, 'inflow'); assert(size(numerators), [2 3]); "
      "assert(denominators{1, 2}, [21 10 1]); assert(delays(1, 1), 1.5)");
  EXPECT_EQ(
      std::system(absl::StrCat(octave, " --quiet --no-init-file --eval \"",
                               program, "\"")
                      .c_str()),
      0);
}

TEST_F(MatFile, SaysWhatIsWrong) {
  const std::string bytes = *FormatMat(TankSteps());
  const std::string torn =
      folder_.Write("torn.mat", bytes.substr(0, bytes.size() / 2));
  EXPECT_THAT(std::string(ReadModelFile(torn).status().message()),
              HasSubstr("torn.mat: cannot be read"));
  const std::string only_header =
      folder_.Write("header.mat", bytes.substr(0, 128));
  EXPECT_THAT(std::string(ReadModelFile(only_header).status().message()),
              AllOf(HasSubstr("header.mat: "), HasSubstr("'name'")));
  const std::string text = folder_.Write("text.mat", "MATLAB 5.0 MAT-file");
  EXPECT_THAT(std::string(ReadModelFile(text).status().message()),
              HasSubstr("text.mat: cannot be read"));
  EXPECT_FALSE(ReadMatModel("/no/such.mat").ok());
  // Two texts that are said to be more.
  std::string many = bytes;
  const std::size_t place = many.find("output_units");
  ASSERT_NE(place, std::string::npos);
  many[place - 14] = 0x02;  // a byte of the number of rows
  EXPECT_THAT(
      std::string(
          ReadModelFile(folder_.Write("many.mat", many)).status().message()),
      AllOf(HasSubstr("many.mat"), HasSubstr("damaged")));
}

// Sizes are looked at before memory is asked for, or entries are gone over.
TEST_F(MatFile, SizesThatTheFileDoesNotHaveAreDamage) {
  const std::string bytes = *FormatMat(TankSteps());
  for (const char* const name :
       {"inputs", "output_units", "interval", "disturbances"}) {
    std::string damaged = bytes;
    const std::size_t place = damaged.find(name);
    ASSERT_NE(place, std::string::npos);
    // The highest byte of the last size.
    damaged[place - 9] = 0x10;
    EXPECT_THAT(std::string(ReadModelFile(folder_.Write("sizes.mat", damaged))
                                .status()
                                .message()),
                HasSubstr("damaged"))
        << name;
  }
}

TEST_F(MatFile, CompressedVariablesAreLookedAtToo) {
  const auto with_interval = [this](bool is_damaged) {
    const std::string path =
        folder_.Write("packed.mat", *FormatMat(TankSteps()));
    Mat mat(Mat_Open(path.c_str(), MAT_ACC_RDWR));
    EXPECT_EQ(Mat_VarDelete(mat.get(), "interval"), 0);
    mat.reset();
    mat.reset(Mat_Open(path.c_str(), MAT_ACC_RDWR));
    std::vector<double> values(200, 0.7);
    Sizes sizes = {1, 1};
    const Variable variable(Mat_VarCreate("interval", MAT_C_DOUBLE,
                                          MAT_T_DOUBLE, 2, sizes.data(),
                                          values.data(), 0));
    EXPECT_EQ(Mat_VarWrite(mat.get(), variable.get(), MAT_COMPRESSION_ZLIB), 0);
    mat.reset();
    std::string bytes = *ReadFile(path);
    // In the compressed part, which stands last.
    if (is_damaged) bytes[bytes.size() - 12] ^= 0x55;
    return ReadModelFile(folder_.Write("packed.mat", bytes)).status();
  };
  EXPECT_TRUE(with_interval(false).ok()) << with_interval(false);
  EXPECT_THAT(std::string(with_interval(true).message()), HasSubstr("damaged"));
}

TEST_F(MatFile, TextsAreNoLongerThanNamesAre) {
  const auto with_name = [this](std::size_t characters) {
    const std::string path =
        folder_.Write("named.mat", *FormatMat(TankSteps()));
    Mat mat(Mat_Open(path.c_str(), MAT_ACC_RDWR));
    EXPECT_EQ(Mat_VarDelete(mat.get(), "name"), 0);
    mat.reset();
    mat.reset(Mat_Open(path.c_str(), MAT_ACC_RDWR));
    std::string text(characters, 'x');
    Sizes sizes = {1, characters};
    const Variable variable(Mat_VarCreate("name", MAT_C_CHAR, MAT_T_UTF8, 2,
                                          sizes.data(), text.data(), 0));
    EXPECT_EQ(Mat_VarWrite(mat.get(), variable.get(), MAT_COMPRESSION_NONE), 0);
    mat.reset();
    return ReadModelFile(path).status();
  };
  EXPECT_TRUE(with_name(10'000).ok()) << with_name(10'000);
  EXPECT_THAT(std::string(with_name(10'001).message()),
              AllOf(HasSubstr("'name'"), HasSubstr("at most 10000")));
}

// Variables of other sizes, or of other kinds.
TEST_F(MatFile, NamesTheVariableThatIsWrong) {
  const auto with = [this](const char* name, Sizes sizes,
                           std::vector<double> values) {
    const std::string path =
        folder_.Write("changed.mat", *FormatMat(TankSteps()));
    Mat mat(Mat_Open(path.c_str(), MAT_ACC_RDWR));
    EXPECT_EQ(Mat_VarDelete(mat.get(), name), 0);
    mat.reset();
    mat.reset(Mat_Open(path.c_str(), MAT_ACC_RDWR));
    const Variable variable(Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE,
                                          static_cast<int>(sizes.size()),
                                          sizes.data(), values.data(), 0));
    EXPECT_EQ(Mat_VarWrite(mat.get(), variable.get(), MAT_COMPRESSION_NONE), 0);
    mat.reset();
    return std::string(ReadModelFile(path).status().message());
  };
  EXPECT_THAT(with("interval", {1, 2}, {1.0, 2.0}), HasSubstr("'interval'"));
  EXPECT_THAT(with("interval", {1, 1}, {-1.0}), HasSubstr("interval"));
  EXPECT_THAT(with("inputs", {1, 1}, {1.0}), HasSubstr("'inputs'"));
  EXPECT_THAT(with("name", {1, 1}, {1.0}), HasSubstr("'name'"));
  EXPECT_THAT(with("step_responses", {12, 2}, std::vector<double>(24, 1.0)),
              AllOf(HasSubstr("'step_responses'"), HasSubstr("12 2 3")));
  EXPECT_THAT(with("step_responses", {12, 2, 3}, std::vector<double>(72, NAN)),
              AllOf(HasSubstr("'step_responses'"), HasSubstr("NaN")));
}

}  // namespace
}  // namespace mle
