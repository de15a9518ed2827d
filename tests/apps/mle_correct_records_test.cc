// mle_correct on records with what a historian does to them: lost and rounded
// values, outliers, other names and units, inputs that are missing.

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/file.h"
#include "tests/apps/correct_runs.h"

namespace mle {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// The table with these columns only, under other names where these are given.
std::string WithColumns(const std::string& table,
                        const std::vector<std::string>& kept) {
  std::vector<std::string> lines =
      absl::StrSplit(table, '\n', absl::SkipEmpty());
  const std::vector<std::string> names = absl::StrSplit(lines[0], ',');
  for (std::string& line : lines) {
    const std::vector<std::string> fields = absl::StrSplit(line, ',');
    std::vector<std::string> taken;
    for (std::size_t c = 0; c < names.size(); ++c) {
      if (std::find(kept.begin(), kept.end(), names[c]) != kept.end()) {
        taken.push_back(fields[c]);
      }
    }
    line = absl::StrJoin(taken, ",");
  }
  return absl::StrJoin(lines, "\n") + "\n";
}

TEST(MleCorrectRecords, OutputsMayBeChosen) {
  const HeaterExample example(WithHalvedGain());
  const nlohmann::json all = example.Run();
  const nlohmann::json one = example.Run({"--outputs=y1"});
  EXPECT_EQ(one["decision"], "corrected");
  EXPECT_EQ(one["elements"].size(), 2u);
  EXPECT_NEAR(ElementOf(one, "y1", "u1")["gain_ratio"],
              ElementOf(all, "y1", "u1")["gain_ratio"].get<double>(), 0.02);
  EXPECT_EQ(example.Run({"--outputs=y2"})["decision"], "no_change");
  const report::ProcessResult run = RunTested(CorrectionFlags(
      example.model, example.data, example.out, {"--outputs=y3"}));
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, AllOf(HasSubstr("--outputs=y3"),
                             HasSubstr("the model has no such output; it has "
                                       "y1, y2")));
}

// What can be judged without a column of y2 is judged, and what is not is said.
TEST(MleCorrectRecords, OutputsWithoutAColumnAreLeftOut) {
  const HeaterExample example(WithHalvedGain());
  const std::string data = example.scratch.Write(
      "part.csv", WithColumns(*ReadFile(example.data),
                              {"time", "y1", "y1_setpoint", "u1", "u2"}));
  const report::ProcessResult run =
      RunTested(CorrectionFlags(example.model, data, example.out));
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("y2 is not judged: the records have no column "
                                 "of it."));
  const nlohmann::json result = ParsedJson(example.out + "/result.json");
  EXPECT_EQ(result["decision"], "corrected");
  EXPECT_EQ(result["elements"].size(), 2u);
  EXPECT_THAT(result["warnings"].dump(), HasSubstr("y2 is not judged"));
}

// An input that moves all outputs is needed, and so is a column that is meant.
TEST(MleCorrectRecords, AMissingInputOfAllOutputsIsAnError) {
  const HeaterExample example(WithHalvedGain());
  const std::string text = *ReadFile(example.data);
  for (const std::string& input : {"u1", "u2"}) {
    const std::string data = example.scratch.Write(
        "part.csv", WithColumns(text, {"time", "y1", "y1_setpoint", "y2",
                                       "y2_setpoint", input}));
    const report::ProcessResult run =
        RunTested(CorrectionFlags(example.model, data, example.out));
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.err, HasSubstr(input == "u1" ? "there is no column 'u2'"
                                                 : "there is no column 'u1'"));
  }
}

// Each tag in a file of its own.
TEST(MleCorrectRecords, FilesOfOneTagEachAreJoined) {
  const HeaterExample example(WithHalvedGain());
  const std::string text = *ReadFile(example.data);
  std::vector<std::string> files;
  for (const std::string name :
       {"y1", "y1_setpoint", "y2", "y2_setpoint", "u1", "u2"}) {
    files.push_back(example.scratch.Write(name + ".csv",
                                          WithColumns(text, {"time", name})));
  }
  const nlohmann::json joined = Correct(
      CorrectionFlags(example.model, absl::StrJoin(files, ","), example.out),
      example.out);
  const nlohmann::json whole = example.Run();
  EXPECT_EQ(joined["decision"], whole["decision"]);
  EXPECT_EQ(ElementOf(joined, "y1", "u1")["gain_ratio"],
            ElementOf(whole, "y1", "u1")["gain_ratio"]);
}

TEST(MleCorrectRecords, GapsOutliersAndRoundingAreSaidAndSurvived) {
  const HeaterExample clean(WithHalvedGain());
  const HeaterExample faulty(
      WithHalvedGain(),
      {"--lost_probability=0.05", "--lost_input_probability=0.02",
       "--outlier_probability=0.01", "--outlier_size=1", "--quantum=0.003",
       "--faults_only_in_record"});
  const nlohmann::json before = clean.Run();
  const nlohmann::json result = faulty.Run();
  EXPECT_EQ(result["decision"], "corrected");
  EXPECT_GT(result["channels"][0]["bad"], 20);
  EXPECT_GT(result["channels"][0]["outliers"], 1);
  // In units of the initial distance: the same noise, fewer samples.
  EXPECT_LT(result["truth"]["E_corrected"],
            3.0 * before["truth"]["E_corrected"].get<double>() +
                1e-3 * before["truth"]["E_initial"].get<double>());
}

// An output of which four samples of five are lost keeps its elements, and that
// is why: its inputs do move.
TEST(MleCorrectRecords, AnOutputThatLacksSamplesIsSaidToLackThem) {
  const HeaterExample example(WithHalvedGain());
  std::vector<std::string> lines =
      absl::StrSplit(*ReadFile(example.data), '\n', absl::SkipEmpty());
  const std::vector<std::string> names = absl::StrSplit(lines[0], ',');
  const auto column = std::find(names.begin(), names.end(), "y2");
  ASSERT_NE(column, names.end());
  for (std::size_t k = 1; k < lines.size(); ++k) {
    if (k % 400 == 1) continue;
    std::vector<std::string> fields = absl::StrSplit(lines[k], ',');
    fields[column - names.begin()] = "Bad";
    lines[k] = absl::StrJoin(fields, ",");
  }
  const std::string data =
      example.scratch.Write("lost.csv", absl::StrJoin(lines, "\n") + "\n");
  const nlohmann::json result =
      Correct(CorrectionFlags(example.model, data, example.out), example.out);
  EXPECT_EQ(result["decision"], "corrected");
  EXPECT_EQ(ElementOf(result, "y1", "u1")["aged"], true);
  EXPECT_FALSE(ElementOf(result, "y2", "u1").value("aged", false));
  const std::string advice = result["advice"].dump();
  EXPECT_THAT(advice, HasSubstr("Of y2 only 0."));
  EXPECT_THAT(advice, Not(HasSubstr("hardly")));
}

// Columns of other names and units, of a scale with an exponent and of one that
// turns the sign, are the model's channels.
TEST(MleCorrectRecords, TagsAreMappedWithTheirUnits) {
  const HeaterExample example(WithHalvedGain());
  std::vector<std::string> lines =
      absl::StrSplit(*ReadFile(example.data), '\n', absl::SkipEmpty());
  const std::vector<std::string> names = absl::StrSplit(lines[0], ',');
  for (std::string& line : lines) {
    std::vector<std::string> fields = absl::StrSplit(line, ',');
    for (std::size_t c = 0; c < names.size(); ++c) {
      double value = 0.0;
      const bool header = !absl::SimpleAtod(fields[c], &value);
      if (names[c] == "y1") {
        fields[c] =
            header ? "TI 101" : absl::StrFormat("%.17g", (value - 5) / 0.2);
      } else if (names[c] == "u1") {
        fields[c] = header ? "FC-7.OP" : absl::StrFormat("%.17g", -value);
      }
    }
    line = absl::StrJoin(fields, ",");
  }
  const std::string data = example.scratch.Write(
      "tags.csv", absl::StrCat(absl::StrJoin(lines, "\n"), "\n"));
  const auto correct = [&](const std::string& tags) {
    return RunTested(
        CorrectionFlags(example.model, data, example.out,
                        {"--tags=" + tags, "--truth=" + example.plant}));
  };
  const nlohmann::json before = example.Run();
  ASSERT_EQ(correct("TI 101=y1*2e-1+5,FC-7.OP=u1*-1").exit_code, 0);
  const nlohmann::json after = ParsedJson(example.out + "/result.json");
  EXPECT_EQ(after["decision"], "corrected");
  EXPECT_NEAR(ElementOf(after, "y1", "u1")["gain_ratio"],
              ElementOf(before, "y1", "u1")["gain_ratio"].get<double>(), 1e-6);
  EXPECT_NEAR(after["truth"]["E_corrected"],
              before["truth"]["E_corrected"].get<double>(),
              1e-6 * before["truth"]["E_initial"].get<double>());

  for (const auto& [tags, message] :
       {std::pair("y1", "not of the form TAG=CHANNEL"),
        {"TI 101=y7*2", "'y7' is not an input, output"},
        {"TI 101=y1*two", "*SCALE+OFFSET is expected"},
        {"TI 101=y1*2+", "*SCALE+OFFSET is expected"}}) {
    const report::ProcessResult run = correct(tags);
    EXPECT_EQ(run.exit_code, 2) << tags;
    EXPECT_THAT(run.err, AllOf(HasSubstr("--tags"), HasSubstr(message)));
  }
}

// A window whose inputs are missing for a while is cut where its set-point
// change is left, and left out where it is not.
TEST(MleCorrectRecords, WindowsWithoutInputsAreCutOrLeftOut) {
  const HeaterExample example(WithHalvedGain());
  const std::string text = *ReadFile(example.data);
  const auto run = [&](double from, double to, int exit_code = 0) {
    std::vector<std::string> lines =
        absl::StrSplit(text, '\n', absl::SkipEmpty());
    const std::vector<std::string> names = absl::StrSplit(lines[0], ',');
    for (std::size_t k = 1; k < lines.size(); ++k) {
      std::vector<std::string> fields = absl::StrSplit(lines[k], ',');
      double time = 0.0;
      EXPECT_TRUE(absl::SimpleAtod(fields[0], &time));
      if (time < from || time > to) continue;
      for (std::size_t c = 0; c < names.size(); ++c) {
        if (names[c] == "u1") fields[c].clear();
      }
      lines[k] = absl::StrJoin(fields, ",");
    }
    const std::string data = example.scratch.Write(
        "missing.csv", absl::StrCat(absl::StrJoin(lines, "\n"), "\n"));
    return Correct(CorrectionFlags(example.model, data, example.out,
                                   {"--max_gap=1", "--truth=" + example.plant}),
                   example.out, exit_code);
  };
  const nlohmann::json whole = example.Run();
  ASSERT_EQ(whole["windows"].size(), 2U);
  const double end = whole["windows"][0]["to"];

  const nlohmann::json cut = run(end - 10.0, end - 7.0);
  EXPECT_THAT(cut["warnings"].dump(), HasSubstr("is cut to its longest part"));
  ASSERT_EQ(cut["windows"].size(), 2U);
  EXPECT_NEAR(cut["windows"][0]["to"].get<double>(), end - 10.0, 0.5);
  EXPECT_LT(cut["truth"]["E_corrected"],
            0.05 * cut["truth"]["E_initial"].get<double>());

  const nlohmann::json left_out = run(59.0, 62.0, 0);
  EXPECT_EQ(left_out["decision"], "corrected");
  EXPECT_THAT(left_out["warnings"].dump(),
              HasSubstr("inputs are missing around its set-point change"));
  EXPECT_EQ(left_out["windows"].size(), 1U);
}

// Now and then eight samples in a row of both outputs off by 15 to 45
// deviations, to one side: the model finds what neighbours do not.
TEST(MleCorrectRecords, BurstsOfOutliersAreFoundByTheModel) {
  const HeaterExample example(WithHalvedGain());
  std::vector<std::string> lines =
      absl::StrSplit(*ReadFile(example.data), '\n', absl::SkipEmpty());
  const std::vector<std::string> names = absl::StrSplit(lines[0], ',');
  int spoilt = 0;
  for (std::size_t k = 20; k + 60 < lines.size(); k += 97) {
    const double side = k % 2 == 0 ? 1.0 : -1.0;
    for (std::size_t i = k; i < k + 8; ++i) {
      std::vector<std::string> fields = absl::StrSplit(lines[i], ',');
      for (std::size_t c = 0; c < names.size(); ++c) {
        if (names[c] != "y1" && names[c] != "y2") continue;
        double value = 0.0;
        ASSERT_TRUE(absl::SimpleAtod(fields[c], &value));
        const double size = 0.5 + 0.125 * static_cast<double>((i * 7 + c) % 8);
        fields[c] = absl::StrCat(value + side * size);
      }
      lines[i] = absl::StrJoin(fields, ",");
      ++spoilt;
    }
  }
  for (const char* const estimator :
       {"--estimator=output_error", "--estimator=arx"}) {
    SCOPED_TRACE(estimator);
    const std::vector<std::string> flags = {estimator,
                                            "--conversion_samples=20000"};
    const nlohmann::json clean = HeaterExample(WithHalvedGain()).Run(flags);
    EXPECT_FALSE(clean["channels"][0].contains("outliers_by_model"));
    const std::string data = example.scratch.Write(
        "spoilt.csv", absl::StrCat(absl::StrJoin(lines, "\n"), "\n"));
    std::vector<std::string> all = flags;
    all.push_back("--truth=" + example.plant);
    const nlohmann::json result = Correct(
        CorrectionFlags(example.model, data, example.out, all), example.out);
    EXPECT_EQ(result["decision"], "corrected");
    for (int i = 0; i < 2; ++i) {
      const int found = result["channels"][i]["outliers"].get<int>() +
                        result["channels"][i]["outliers_by_model"].get<int>();
      EXPECT_GT(result["channels"][i]["outliers_by_model"], 0);
      // Some lie outside the windows.
      EXPECT_GT(found, spoilt / 2);
      EXPECT_LE(found, spoilt + 2);
    }
    EXPECT_LT(result["truth"]["E_corrected"],
              3.0 * clean["truth"]["E_corrected"].get<double>() +
                  1e-3 * clean["truth"]["E_initial"].get<double>());
  }
}

}  // namespace
}  // namespace mle
