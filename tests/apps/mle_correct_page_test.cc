// The page of mle_correct shows what its other files hold, and its figures are
// files as well.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/correct_runs.h"
#include "tests/apps/page_tables.h"
#include "tests/apps/report/shown_figures.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

// A run in which a gain has halved, with all that it writes: one for all tests,
// which leave it as it is.
class MleCorrectPage : public ::testing::Test {
 private:
  struct Run {
    Run() {
      const std::string model =
          scratch.Write("model.json", HeaterJson(Heater()));
      const std::string plant =
          scratch.Write("plant.json", HeaterJson(WithHalvedGain()));
      const std::string data =
          SimulateHeater(scratch, "run.csv", model, plant,
                         {"--lost_probability=0.02", "--seed=3"});
      result = Correct(CorrectionFlags(model, data, out,
                                       {"--figures=true", "--truth=" + plant,
                                        "--control_period=0.5"}),
                       out);
      html = Content(out + "/report.html");
    }
    const ScratchFolder scratch;
    const std::string out = scratch / "out";
    std::string html;
    nlohmann::json result;
  };
  static const Run& TheRun() {
    static const Run run;
    return run;
  }

 protected:
  const ScratchFolder& scratch_ = TheRun().scratch;
  const std::string& out_ = TheRun().out;
  const std::string& html_ = TheRun().html;
  const nlohmann::json& result_ = TheRun().result;
};

void ExpectInterval(const std::string& cell, const nlohmann::json& estimate) {
  const std::string separator = " ± ";
  const std::size_t at = cell.find(separator);
  ASSERT_NE(at, std::string::npos) << cell;
  ExpectShows(cell, estimate["value"]);
  ExpectShows(cell.substr(at + separator.size()),
              0.5 * (estimate["upper"].get<double>() -
                     estimate["lower"].get<double>()));
}

TEST_F(MleCorrectPage, TablesShowTheValuesOfTheResult) {
  const PageTable table = TableOf(html_, "Elements; times in");
  ASSERT_EQ(table.rows.size(), 1u + 3u * 4u);
  std::size_t row = 1;
  for (const char* const output : {"y1", "y2"}) {
    for (const char* const input : {"u1", "u2"}) {
      const nlohmann::json element = ElementOf(result_, output, input);
      EXPECT_EQ(table.rows[row][0], std::string(output) + " ← " + input);
      if (element["p_value"] < 1e-300) {
        EXPECT_THAT(table.rows[row][5], HasSubstr("less than 10⁻³⁰⁰"));
      } else {
        ExpectShows(table.rows[row][5], element["p_value"]);
      }
      for (const char* const name : {"gain", "time_constant", "delay"}) {
        SCOPED_TRACE(table.rows[row][0] + " " + name);
        const nlohmann::json& value = element[name];
        ExpectShows(table.rows[row][2], value["initial"]);
        ExpectInterval(table.rows[row][3], value["all_free"]);
        if (element["aged"].get<bool>()) {
          ExpectInterval(table.rows[row][4], value["corrected"]);
        } else {
          ExpectShows(table.rows[row][4], value["initial"]);
        }
        ++row;
      }
    }
  }
  const PageTable fits = TableOf(html_, "Fit on parts of windows held out");
  const nlohmann::json& held_out = result_["validation"]["outputs"];
  ASSERT_EQ(fits.rows.size(), 1u + 3u * held_out.size());
  for (std::size_t i = 0; i < held_out.size(); ++i) {
    int line = 0;
    for (const char* const model : {"initial", "corrected"}) {
      const auto& cells = fits.rows[1 + 3 * i + line++];
      ExpectShows(cells[1], held_out[i]["one_step"][model]);
      ExpectShows(cells[2], held_out[i]["several_steps"][model]);
      ExpectShows(cells[3], held_out[i]["simulated"][model]);
    }
  }
}

TEST_F(MleCorrectPage, OpensWithBadgeHeadlineAndWhatToDo) {
  const std::size_t verdict = html_.find("class=\"verdict changed\"");
  ASSERT_NE(verdict, std::string::npos);
  const std::string opening =
      html_.substr(verdict, html_.find("</header>") - verdict);
  EXPECT_THAT(opening, HasSubstr("<span class=\"badge\">corrected</span>"));
  EXPECT_THAT(opening, HasSubstr("Gain of y1 ←\u00A0u1 fell by "));
  EXPECT_THAT(opening, HasSubstr("Use the corrected model"));
  EXPECT_THAT(opening, HasSubstr("On held-out data"));
  EXPECT_THAT(opening, HasSubstr("95\u00A0% confidence interval"));
  // A p-value is for those who open a fold.
  EXPECT_EQ(opening.find("(p "), std::string::npos);
  ASSERT_EQ(result_["verdict"].size(), 2u);
  const std::string aged = result_["verdict"][0];
  EXPECT_THAT(aged, HasSubstr("1 of 4 elements have changed, y1 ← u1"));
  EXPECT_LT(html_.find("What the verdict rests on"), html_.find(aged));
}

// ± is explained once; no other quantity has the sign.
TEST_F(MleCorrectPage, SaysOnceWhatTheIntervalsAre) {
  const std::string note = "±\u00A0is half a";
  const std::size_t first = html_.find(note);
  ASSERT_NE(first, std::string::npos);
  EXPECT_EQ(html_.find(note, first + 1), std::string::npos);
  EXPECT_EQ(html_.find("±\u00A0one standard error"), std::string::npos);
}

TEST_F(MleCorrectPage, TheTableForTheControllerIsTheWrittenModel) {
  const PageTable table = TableOf(html_, "The model as first-order elements");
  ASSERT_EQ(table.rows.size(), 1u + 4u);
  for (std::size_t row = 1; row < table.rows.size(); ++row) {
    const nlohmann::json element =
        ElementOf(result_, table.rows[row][0], table.rows[row][1]);
    ExpectShows(table.rows[row][2], element["fopdt"]["gain"]);
    ExpectShows(table.rows[row][3], element["fopdt"]["time_constant"]);
    ExpectShows(table.rows[row][4], element["fopdt"]["delay"]);
    const bool aged = element["aged"];
    EXPECT_EQ(table.rows[row][5].empty(), !aged);
    // Intervals of what has changed.
    EXPECT_EQ(table.rows[row][2].find(" ± ") != std::string::npos, aged);
  }
  // What the button copies, without them.
  const std::string copied = "data-text=\"output\tinput\tgain\t";
  const std::size_t begin = html_.find(copied);
  ASSERT_NE(begin, std::string::npos);
  EXPECT_EQ(html_.substr(begin, html_.find('"', begin + copied.size()) - begin)
                .find("±"),
            std::string::npos);
}

TEST_F(MleCorrectPage, TheLoopFollowsSetPointsBetterOnThePlantAsCorrected) {
  EXPECT_THAT(html_, HasSubstr("What it means for control"));
  EXPECT_THAT(Content(out_ + "/control.svg"),
              HasSubstr("with the corrected model"));
}

// Without the controller's tuning nothing is said of loops.
TEST_F(MleCorrectPage, WithoutTheTuningPredictionsAreCompared) {
  const std::string out = scratch_ / "not_told";
  const nlohmann::json result = Correct(
      CorrectionFlags(scratch_ / "model.json", scratch_ / "run.csv", out), out);
  const std::string html = Content(out + "/report.html");
  EXPECT_THAT(html, HasSubstr("What it means for predictions</h2>"));
  EXPECT_THAT(html, HasSubstr("the correction moves predictions up to "));
  EXPECT_THAT(html, HasSubstr("y2 unchanged."));
  EXPECT_THAT(html, HasSubstr("--control_period"));
  EXPECT_EQ(html.find("What it means for control</h2>"), std::string::npos);
  EXPECT_EQ(html.find("Tuning of the controller"), std::string::npos);
  EXPECT_TRUE(result["tuning"].empty());
  EXPECT_FALSE(result_["tuning"].empty());
}

TEST_F(MleCorrectPage, SaysWhyLoopsAreNotCompared) {
  const std::string out = scratch_ / "not_compared";
  Correct(CorrectionFlags(scratch_ / "model.json", scratch_ / "run.csv", out,
                          {"--control_period=1e6"}),
          out);
  EXPECT_THAT(Content(out + "/report.html"),
              HasSubstr("cannot be compared: a comparison of loops of this "
                        "control period takes too many samples."));
}

// A horizon that ends within all dead times.
TEST(MleCorrectPageTest, ResponsesThatHaveNotBegunAreNoFigure) {
  const HeaterExample example((Heater()));
  example.Run({"--figures=true", "--response_horizon=1"});
  EXPECT_TRUE(std::filesystem::exists(example.out + "/records.svg"));
  EXPECT_FALSE(std::filesystem::exists(example.out + "/step_responses.svg"));
}

TEST_F(MleCorrectPage, FiguresShowTheResponsesOfTheFile) {
  // Behind the outputs measured and simulated.
  const report::ShownPanel panel =
      report::FiguresOf(html_, true).at(1).panels.at(0);
  const auto lines = ParsedCsv(out_ + "/step_response.csv");
  int compared = 0;
  for (const report::ShownSeries& series : panel.series) {
    const int column = series.label == "controller's model" ? 1
                       : series.label == "corrected"        ? 5
                                                            : 9;
    ASSERT_EQ(series.x.size(), lines.size() - 1);
    for (std::size_t k = 1; k < lines.size(); ++k) {
      EXPECT_NEAR(series.y[k - 1], std::stod(lines[k][column]),
                  1e-4 * (panel.y.max - panel.y.min));
      ++compared;
    }
  }
  EXPECT_EQ(compared, 3 * static_cast<int>(lines.size() - 1));
}

TEST_F(MleCorrectPage, RecordsAreDrawnWithTheirWindowsAndBadSamples) {
  // Of the file, which is the picture of the page.
  const report::ShownPanel panel =
      report::FiguresOf(Content(out_ + "/records.svg"), false)
          .at(0)
          .panels.at(0);
  EXPECT_EQ(panel.spans, static_cast<int>(result_["windows"].size()));
  const auto bad = std::find_if(
      panel.series.begin(), panel.series.end(),
      [](const report::ShownSeries& s) { return s.label == "not used"; });
  ASSERT_NE(bad, panel.series.end());
  // All that are lost in the file.
  int lost = 0;
  const auto lines = ParsedCsv(scratch_ / "run.csv");
  for (std::size_t k = 1; k < lines.size(); ++k) {
    lost += lines[k][1].empty() ? 1 : 0;
  }
  EXPECT_GT(lost, 5);
  EXPECT_EQ(bad->x.size(), static_cast<std::size_t>(lost));
}

TEST_F(MleCorrectPage, EveryFigureIsAFileToo) {
  for (const char* const name :
       {"step_responses", "changed_responses", "control", "mismatch_map",
        "records", "predictions", "autocorrelation", "cross_correlation"}) {
    const std::string base = out_ + "/" + name;
    EXPECT_EQ(Content(base + ".svg").find("<?xml"), 0u) << name;
    EXPECT_EQ(Content(base + ".png").find("\x89PNG"), 0u) << name;
    EXPECT_EQ(Content(base + ".pdf").find("%PDF"), 0u) << name;
  }
  EXPECT_THAT(Content(out_ + "/mismatch_map.svg"), HasSubstr("gain × 0."));
  // Those of another run do not stay beside a page without figures.
  const std::string again = scratch_ / "again";
  std::filesystem::copy(out_, again);
  Correct(CorrectionFlags(scratch_ / "model.json", scratch_ / "run.csv", again),
          again);
  for (const auto& file : std::filesystem::directory_iterator(again)) {
    const std::string extension = file.path().extension().string();
    EXPECT_TRUE(extension != ".svg" && extension != ".png" &&
                extension != ".pdf")
        << file.path();
  }
}

// Below the map of pairs, and what the terminal says first.
struct Shown {
  std::string out;
  std::string html;
};

Shown Show(const HeaterExample& example, const std::vector<std::string>& more) {
  const report::ProcessResult run = RunTested(
      CorrectionFlags(example.model, example.data, example.out, more));
  return {run.out, Content(example.out + "/report.html")};
}

TEST(MleCorrectMistakes, ExchangedTagsAreTheHeadline) {
  const HeaterExample example((Heater()));
  const Shown shown = Show(example, {"--tags=u1=u2,u2=u1"});
  EXPECT_THAT(shown.out,
              HasSubstr("Keep the controller's model for now: correct this and "
                        "run again.\nThe tags of u1 and u2 seem to be "
                        "swapped.\nCorrect it with --tags='"));
  EXPECT_EQ(shown.out.find("likelihood"), std::string::npos);
  EXPECT_THAT(shown.html, HasSubstr("</span> The tags of u1 and u2 seem to be "
                                    "swapped</h1>"));
  EXPECT_THAT(shown.html, HasSubstr(">not estimated</td>"));
  EXPECT_THAT(shown.html, HasSubstr("Not estimated, because: The tags of u1"));
  EXPECT_EQ(shown.html.find("hardly moves by itself"), std::string::npos);
}

TEST(MleCorrectMistakes, ATurnedSignIsSaidToBePerhapsMistyped) {
  Heater mistyped;
  mistyped.third.gain = -mistyped.third.gain;
  const HeaterExample example((Heater()));
  example.scratch.Write("model.json", HeaterJson(mistyped));
  const Shown shown = Show(example, {});
  EXPECT_THAT(shown.out, HasSubstr("Keep the controller's model for now"));
  EXPECT_THAT(shown.out, HasSubstr("Y2 ← u1 acts in the opposite direction: "
                                   "compare the sign of its gain"));
}

TEST(MleCorrectHeadline, NamesTheOtherElementsThatHaveChanged) {
  Heater aged;
  aged.first.gain = 1.0;
  aged.fourth.gain = 2.4;
  const Shown shown = Show(HeaterExample(aged), {});
  EXPECT_THAT(shown.out, HasSubstr("; also y"));
  EXPECT_THAT(shown.out, HasSubstr(" changed."));
  for (const char* const pair : {"y1 ← u1", "y2 ← u2"}) {
    EXPECT_THAT(shown.out, HasSubstr(pair));
  }
}

// A map of thirteen inputs is wider than a page: what has changed is listed,
// and what is known of all others said in a sentence.
TEST(MleCorrectTable, ListsTheChangesOfAWidePlant) {
  const HeaterExample example(WithHalvedGain());
  nlohmann::json model = nlohmann::json::parse(HeaterJson(Heater()));
  std::string head;
  std::string at_rest;
  for (int j = 3; j <= 13; ++j) {
    const std::string name = "u" + std::to_string(j);
    model["inputs"].push_back({{"name", name}, {"unit", "%"}});
    head += "," + name;
    at_rest += ",0";
  }
  model["elements"].push_back({{"output", "y2"},
                               {"input", "u13"},
                               {"gain", 1.0},
                               {"time_constant", 5.0},
                               {"delay", 1.0}});
  example.scratch.Write("model.json", model.dump());
  std::istringstream narrow(Content(example.data));
  std::string wide;
  for (std::string line; std::getline(narrow, line);) {
    wide += line + (wide.empty() ? head : at_rest) + "\n";
  }
  example.scratch.Write("run.csv", wide);
  const Shown shown = Show(example, {"--verbose"});
  const PageTable table =
      TableOf(shown.html, "Changes by element, the largest first");
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_EQ(table.rows[1][0], "y1 ← u1");
  EXPECT_THAT(table.rows[1][1], HasSubstr(" %"));
  EXPECT_THAT(table.rows[1][2], HasSubstr("gain × 0.5"));
  EXPECT_THAT(shown.html,
              HasSubstr("Of the other 4 elements of the model no change is "
                        "seen in 3; the records do not determine 1."));
  EXPECT_THAT(shown.out, HasSubstr("y2 ← u13  kept; not informed"));
}

// Where the table to type in is not the model written, the page says which to
// use.
TEST(MleCorrectTable, SaysWhereFirstOrderIsNotTheModel) {
  const auto with_second_order = [](double gain) {
    nlohmann::json model = nlohmann::json::parse(HeaterJson(Heater()));
    nlohmann::json& element = model["elements"][0];
    element.erase("gain");
    element.erase("time_constant");
    element["numerator"] = {gain};
    element["denominator"] = {12.0, 7.0, 1.0};
    return model.dump();
  };
  const HeaterExample example((Heater()));
  example.scratch.Write("model.json", with_second_order(2.0));
  example.scratch.Write("plant.json", with_second_order(1.0));
  SimulateHeater(example.scratch, "run.csv", example.model, example.plant);
  const std::string html = Show(example, {}).html;
  EXPECT_THAT(html,
              HasSubstr("Not of first order are y1 ←\u00A0u1 (by up to "));
  EXPECT_THAT(html, HasSubstr("use model.json or step_response.csv instead"));
  EXPECT_EQ(
      Show(HeaterExample(WithHalvedGain()), {}).html.find("Not of first order"),
      std::string::npos);
}

}  // namespace
}  // namespace mle
