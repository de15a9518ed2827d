// What mle_correct answers to flags and files it cannot use: exit code 2, a
// line that names the flag or file and what would be right, and no output.

#include <filesystem>
#include <string>
#include <vector>

#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/correct_runs.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

// A model and a record that are good, and a folder for what is not.
class MleCorrectBadInput : public ::testing::Test {
 protected:
  MleCorrectBadInput()
      : model_(scratch_.Write("model.json", HeaterJson(Heater()))),
        data_(SimulateHeater(scratch_, "run.csv", model_, model_,
                             {"--duration=110", "--setpoints=y1:50:1"})) {}

  // Later flags win.
  void ExpectRefused(const std::vector<std::string>& flags,
                     const std::vector<std::string>& named) const {
    SCOPED_TRACE(::testing::PrintToString(flags));
    const std::string out = scratch_ / "out";
    const report::ProcessResult result =
        RunTested(CorrectionFlags(model_, data_, out, flags));
    EXPECT_EQ(result.exit_code, 2) << result.out << result.err;
    EXPECT_EQ(result.out, "");
    EXPECT_THAT(result.err, HasSubstr("error: "));
    for (const std::string& name : named) {
      EXPECT_THAT(result.err, HasSubstr(name));
    }
    EXPECT_FALSE(std::filesystem::exists(out + "/result.json"));
    EXPECT_FALSE(std::filesystem::exists(out + "/report.html"));
  }

  const ScratchFolder scratch_;
  std::string model_;
  std::string data_;
};

TEST_F(MleCorrectBadInput, NamesDoNotCommandATerminal) {
  const report::ProcessResult result = RunTested(CorrectionFlags(
      model_, data_, scratch_ / "out", {"--\x1b[31m", "--window_after=\x07"}));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.err.find_first_of("\x1b\x07"), std::string::npos);
  EXPECT_THAT(result.err, HasSubstr("\uFFFD"));
}

TEST_F(MleCorrectBadInput, Flags) {
  ExpectRefused({"--nosuch"}, {"--nosuch", "--help"});
  ExpectRefused({"--windw_after=3"}, {"did you mean 'window_after'?"});
  ExpectRefused({"--estimator=outputerror"}, {"did you mean 'output_error'?"});
  ExpectRefused({"--tags=a=y1_setpiont"}, {"did you mean 'y1_setpoint'"});
  ExpectRefused({"--tag_file=" + scratch_ / ""}, {"it is a folder"});
  ExpectRefused({"--json", "--dry_run"}, {"--json", "--dry_run"});
  ExpectRefused({"stray"}, {"'stray'"});
  ExpectRefused({"--model="}, {"--model=FILE.json", "--data"});
  ExpectRefused({"--data="}, {"--data=A.csv,B.csv"});
  ExpectRefused({"--data=,"}, {"--data"});
  ExpectRefused({"--data=" + data_ + "," + data_}, {"--data", "twice"});
  ExpectRefused({"--estimator=best"},
                {"--estimator=best", "choose from output_error"});
  ExpectRefused({"--solver=best"},
                {"--solver=best", "choose from homotopy, coordinate_descent"});
  ExpectRefused({"--robust=best"},
                {"--robust=best", "choose from none, huber and cauchy"});
  ExpectRefused({"--estimator=arx", "--selection=best"},
                {"--selection=best", "choose from blocks"});
  ExpectRefused({"--false_alarm_probability=0"},
                {"--false_alarm_probability=0", "in (0, 1)"});
  ExpectRefused({"--confidence=95"}, {"--confidence=95", "in (0, 1)"});
  ExpectRefused({"--max_time_constant_factor=1"},
                {"--max_time_constant_factor=1", "> 1"});
  ExpectRefused({"--window_before=-1"}, {"--window_before=-1", "≥ 0"});
  ExpectRefused({"--window_after=nan"}, {"--window_after=nan", "finite"});
  ExpectRefused({"--response_horizon=-3"}, {"--response_horizon=-3"});
  ExpectRefused({"--response_horizon=0.3"}, {"--response_horizon=0.3", "5"});
  ExpectRefused({"--max_delay=-1"}, {"--max_delay=-1"});
  ExpectRefused({"--order=-1"}, {"--order=-1", "[0, 100000]"});
  ExpectRefused({"--threads=-1"}, {"--threads=-1", "≥ 0"});
  ExpectRefused({"--validation_folds=1"}, {"--validation_folds=1", "2"});
  ExpectRefused({"--conversion_samples=10"}, {"--conversion_samples=10"});
  ExpectRefused({"--conversion_penalty=-1"}, {"--conversion_penalty=-1"});
  ExpectRefused({"--output_weight=1,2,3"}, {"--output_weight=1,2,3", "3", "2"});
  ExpectRefused({"--move_weight=-1"}, {"--move_weight=-1", "≥ 0"});
  ExpectRefused({"--control_horizon=50"}, {"--control_horizon"});
  ExpectRefused({"--time_format=german"},
                {"--time_format=german", "day_first"});
  ExpectRefused({"--separator=|"}, {"--separator=|", "semicolon"});
  ExpectRefused({"--decimal=dot"}, {"--decimal=dot", "point"});
  ExpectRefused({"--tags=a:b"}, {"--tags=a:b", "TAG=CHANNEL"});
  ExpectRefused({"--tags=a=nosuch"}, {"--tags=a=nosuch", "'nosuch'"});
  ExpectRefused({"--tags=a=u1*x"}, {"--tags=a=u1*x", "SCALE"});
  ExpectRefused({"--change_times=5,x"}, {"--change_times=5,x", "'x'"});
  ExpectRefused({"--number_unit=fortnight"}, {"fortnight"});
  ExpectRefused({"--time_zone=Mars/Olympus"}, {"Mars/Olympus"});
}

TEST_F(MleCorrectBadInput, Models) {
  ExpectRefused({"--model=" + scratch_ / ""}, {"--model", "it is a folder"});
  ExpectRefused({"--truth=" + scratch_ / ""}, {"--truth", "it is a folder"});
  ExpectRefused({"--model=" + scratch_ / "none.json"},
                {"--model", "none.json"});
  const std::string torn = scratch_.Write("torn.json", "{\"name\": ");
  ExpectRefused({"--model=" + torn}, {"--model", torn, "line"});
  ExpectRefused({"--truth=" + torn}, {"--truth", torn});
  const std::string other = scratch_.Write(
      "other.json", absl::StrReplaceAll(HeaterJson(Heater()), {{"u2", "v2"}}));
  ExpectRefused({"--truth=" + other}, {"--truth", "u2", "v2"});
  const std::string idle =
      scratch_.Write("idle.json",
                     R"({"name": "idle", "time_unit": "min",
      "inputs": [{"name": "u1", "unit": ""}],
      "outputs": [{"name": "y1", "unit": ""}], "elements": []})");
  ExpectRefused({"--model=" + idle}, {"--model", "nothing to correct"});
}

TEST_F(MleCorrectBadInput, Records) {
  ExpectRefused({"--data=" + scratch_ / "none.csv"}, {"--data", "none.csv"});
  ExpectRefused({"--data=" + scratch_ / ""}, {"--data", "it is a folder"});
  const std::string empty = scratch_.Write("empty.csv", "");
  ExpectRefused({"--data=" + empty}, {"--data", empty});
  const std::string text = Content(data_);
  const std::string missing = scratch_.Write(
      "missing.csv", absl::StrReplaceAll(text, {{",u2", ",u9"}}));
  ExpectRefused({"--data=" + missing}, {missing, "u"});
  const std::string broken = scratch_.Write(
      "broken.csv", text.substr(0, text.size() / 2) + "\n1e999,x,y,z\n");
  ExpectRefused({"--data=" + broken}, {broken});
  const std::string binary =
      scratch_.Write("binary.csv", std::string("\x7f"
                                               "ELF\0\1\2\3\n\0\0",
                                               11));
  ExpectRefused({"--data=" + binary}, {binary});
  ExpectRefused({"--min_setpoint_change=5"},
                {"nothing to learn", "<output>_setpoint", "--change_times"});
}

TEST_F(MleCorrectBadInput, FoldersThatCannotBeWrittenTo) {
  const std::string file = scratch_.Write("file", "here first\n");
  const report::ProcessResult result =
      RunTested(CorrectionFlags(model_, data_, file + "/below"));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("error: --out: "));
  EXPECT_EQ(Content(file), "here first\n");
}

}  // namespace
}  // namespace mle
