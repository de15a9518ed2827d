#include "mle/maintain/modes.h"

#include <algorithm>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/maintain/records.h"
#include "mle/model/process_simulator.h"

namespace mle {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

ProcessModel Tank() {
  ProcessModel model("tank", "min", {{"steam", ""}}, {{"level", ""}});
  model.element(0, 0) = TransferFunction::FirstOrder(2.0, 5.0, 1.0);
  return model;
}

// A row a minute with these modes.
std::string Rows(const std::vector<std::string>& modes) {
  std::string text = "time,level,steam,FC7.MODE\n";
  for (std::size_t k = 0; k < modes.size(); ++k) {
    absl::StrAppend(&text, k, ",", k % 3, ",", k % 2, ",", modes[k], "\n");
  }
  return text;
}

absl::StatusOr<Modes> Read(const std::string& text,
                           const std::string& channel = "") {
  HistorianOptions options;
  options.columns.unused_tags = {"FC7.MODE"};
  const std::vector<HistorianSource> sources = {TextSource("a.csv", text)};
  const auto import = ImportHistorianSources(sources, Tank(), options);
  EXPECT_TRUE(import.ok()) << import.status();
  return ReadModes(
      [&](const ProcessModel& channels, const HistorianOptions& how) {
        return ImportHistorianSources(sources, channels, how);
      },
      Tank(), options, {{"FC7.MODE", channel}}, import->records);
}

// "0-2 5-5": the samples that are by hand.
std::string ByHandIn(const std::vector<std::string>& modes,
                     const std::string& channel = "") {
  const absl::StatusOr<Modes> read = Read(Rows(modes), channel);
  EXPECT_TRUE(read.ok()) << read.status();
  std::string text;
  for (const ByHand& part : read->by_hand) {
    absl::StrAppend(&text, text.empty() ? "" : " ", part.from, "-", part.to);
  }
  return text;
}

// The words of docs/records.md.
TEST(ModesTest, WordsOfTheDocumentsAreKnown) {
  const auto are_one_mode = [](const std::vector<std::string>& words) {
    const absl::StatusOr<double> first = ModeCode(words[0]);
    ASSERT_TRUE(first.ok()) << first.status();
    for (const std::string& word : words) EXPECT_EQ(*ModeCode(word), *first);
  };
  are_one_mode({"MAN", "MANUAL", "LOCAL", "OFF", "SHED", "STANDBY", "WARM"});
  are_one_mode({"CAS", "RCAS", "ROUT", "BCAS", "REMOTE", "PRD", "ON"});
  are_one_mode({"IMAN", "INIT", "TRK", "LO", "OOS", "HOLD"});
}

TEST(ModesTest, WordsHaveTheNumbersThatStandForThem) {
  const absl::StatusOr<double> by_hand = ModeCode("Man");
  const absl::StatusOr<double> cascade = ModeCode("CAS");
  ASSERT_TRUE(by_hand.ok() && cascade.ok());
  EXPECT_EQ(ByHandIn({absl::StrCat(*cascade), absl::StrCat(*by_hand),
                      absl::StrCat(*cascade)}),
            "1-1");
  EXPECT_THAT(std::string(ModeCode("broken").status().message()),
              HasSubstr("'broken' is not a mode"));
}

TEST(ModesTest, SetPointsOfOtherOutputsStandInTheFileToo) {
  const ProcessModel model("tank", "min", {{"steam", ""}},
                           {{"level", ""}, {"warmth", ""}});
  const std::vector<HistorianSource> sources = {TextSource(
      "a.csv",
      "time,level,level_setpoint,warmth,warmth_setpoint,steam,FC7.MODE\n"
      "0,1,1,2,2,3,CAS\n1,1,1,2,2,4,MAN\n2,1,1,2,2,4,CAS\n")};
  const auto import = [&](const ProcessModel& channels,
                          const HistorianOptions& how) {
    return ImportHistorianSources(sources, channels, how);
  };
  HistorianOptions options;
  options.columns.unused_tags = {"FC7.MODE"};
  const auto records = import(model, options);
  ASSERT_TRUE(records.ok()) << records.status();
  const auto modes = ReadModes(import, model, options, {{"FC7.MODE", "steam"}},
                               records->records);
  ASSERT_TRUE(modes.ok()) << modes.status();
  ASSERT_EQ(modes->by_hand.size(), 1u);
  EXPECT_EQ(modes->by_hand[0].from, 1.0);
}

TEST(ModesTest, WordsAndNumbersAreKnown) {
  EXPECT_EQ(ByHandIn({"MAN", "Man", "CAS", "RCAS", "OFF", "ON", "SHED"}),
            "0-1 4-4 6-6");
  EXPECT_EQ(ByHandIn({"1", "1", "0", "0", "1"}), "2-3");
  EXPECT_EQ(ByHandIn({"IMAN", "MAN", "IMan", "OOS", "MANUAL"}), "1-1 4-4");
  // The set point of a loop below an input is moved by hand in AUTO.
  EXPECT_EQ(ByHandIn({"AUTO", "CAS", "AUTO"}), "");
  EXPECT_EQ(ByHandIn({"AUTO", "CAS", "AUTO"}, "level"), "");
  EXPECT_EQ(ByHandIn({"AUTO", "CAS", "Auto"}, "steam"), "0-0 2-2");
}

TEST(ModesTest, PlacesAreThoseOfTheChannels) {
  const std::string rows = Rows({"MAN", "MAN", "CAS"});
  const auto part = [&](const std::string& channel) {
    return Read(rows, channel)->by_hand.at(0);
  };
  EXPECT_EQ(part("").input, ByHand::kAll);
  EXPECT_EQ(part("").output, ByHand::kAll);
  EXPECT_EQ(part("steam").input, 0);
  EXPECT_EQ(part("steam").output, ByHand::kNone);
  EXPECT_EQ(part("level").input, ByHand::kNone);
  EXPECT_EQ(part("level").output, 0);
}

TEST(ModesTest, LongTablesHaveThemToo) {
  std::string text = "tag,time,value\n";
  for (int k = 0; k < 5; ++k) {
    absl::StrAppend(&text, "level,", k, ",", k % 3, "\nsteam,", k, ",", k % 2,
                    "\nFC7.MODE,", k, ",", k == 2 ? "MAN" : "CAS", "\n");
  }
  const absl::StatusOr<Modes> read = Read(text);
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->by_hand.size(), 1u);
  EXPECT_EQ(read->by_hand[0].from, 2.0);
}

TEST(ModesTest, WhatIsNoModeIsRefused) {
  const auto error = [](const std::string& mode, const std::string& channel) {
    return std::string(
        Read(Rows({"MAN", mode, "CAS"}), channel).status().message());
  };
  EXPECT_THAT(error("Unsinn", ""),
              AllOf(HasSubstr("a.csv: line 3, column 4 ('FC7.MODE'): 'Unsinn' "
                              "is not a mode (mode_tag); choose from MAN"),
                    HasSubstr("RCAS")));
  EXPECT_THAT(error("16", ""),
              HasSubstr("mode_tag = FC7.MODE: 16 is not a mode; choose from"));
  EXPECT_THAT(error("CAS", "stem"),
              HasSubstr("'stem' is not an input or output of the model"));
}

TEST(ModesTest, NotesSayWhatEachTagTells) {
  const auto note = [](const std::string& channel) {
    return Read(Rows({"MAN", "CAS", "CAS", "CAS"}), channel)->notes.at(0).text;
  };
  EXPECT_EQ(note(""),
            "FC7.MODE: the controller was in use for 75 % of the time, and by "
            "hand for 25 %: moves by hand count as changes, and changes of set "
            "points then do not.");
  EXPECT_EQ(note("steam"),
            "FC7.MODE: steam was moved by the controller for 75 % of the time, "
            "and by hand for 25 %: moves by hand count as changes.");
  EXPECT_EQ(note("level"),
            "FC7.MODE: the loop of level was in use for 75 % of the time, and "
            "by hand for 25 %: changes of set points then do not.");
}

// A controller moves the input at every sample, an operator twice: without
// modes nobody knows what to learn from.
TEST(ModesTest, MovesByHandAreChanges) {
  Eigen::MatrixXd inputs(1, 600);
  std::string text = "time,level,steam,FC7.MODE\n";
  const auto by_hand = [](int k) { return k >= 250 && k < 500; };
  for (int k = 0; k < 600; ++k) {
    inputs(0, k) = by_hand(k) ? (k < 300 || k >= 400 ? 0.0 : 1.0)
                              : 0.1 * ((7 * k) % 5 - 2);
  }
  const Eigen::MatrixXd outputs = *SimulateResponse(Tank(), 1.0, inputs);
  for (int k = 0; k < 600; ++k) {
    absl::StrAppend(&text, k, ",", outputs(0, k) + 0.01 * ((k * 13) % 7 - 3),
                    ",", inputs(0, k), ",", by_hand(k) ? "MAN" : "CAS", "\n");
  }
  const std::vector<HistorianSource> sources = {TextSource("a.csv", text)};
  HistorianOptions import;
  RecordOptions options;
  import.columns.ignore_other_columns = true;
  const auto whole = LoadSources(sources, Tank(), import, options);
  ASSERT_TRUE(whole.ok()) << whole.status();
  ASSERT_EQ(whole->windows.size(), 1u);
  EXPECT_EQ(whole->windows[0].record.samples(), 600);
  import.columns.ignore_other_columns = false;
  options.modes = {{"FC7.MODE", "steam"}};
  const auto data = LoadSources(sources, Tank(), import, options);
  ASSERT_TRUE(data.ok()) << data.status();
  std::vector<double> times;
  for (const SetPointWindow& window : data->windows) {
    for (const SetPointChange& change : window.changes) {
      times.push_back(window.record.time(change.sample));
    }
  }
  EXPECT_THAT(times, ::testing::ElementsAre(300.0, 400.0));
  EXPECT_TRUE(std::any_of(
      data->notes.begin(), data->notes.end(), [](const Message& note) {
        return note.text.find("by hand for 42 %") != std::string::npos;
      }));
}

// Set points follow the outputs of loops that are by hand.
TEST(ModesTest, SetPointsOfWhatIsByHandSayNothing) {
  Record record;
  record.sample_time = 1.0;
  record.inputs = Eigen::MatrixXd::Zero(1, 50);
  record.outputs = Eigen::MatrixXd::Zero(1, 50);
  record.set_points = Eigen::MatrixXd::Zero(1, 50);
  record.set_points.rightCols(40).setConstant(1.0);
  record.set_points.rightCols(20).setConstant(3.0);
  const auto changes = [&](const std::vector<ByHand>& by_hand) {
    std::vector<int> samples;
    const auto found = FindChanges({record}, {.by_hand = by_hand});
    for (const SetPointChange& change : found.at(0)) {
      samples.push_back(change.sample);
    }
    return samples;
  };
  EXPECT_THAT(changes({}), ::testing::ElementsAre(10, 30));
  EXPECT_THAT(changes({{5.0, 20.0, ByHand::kNone, 0}}),
              ::testing::ElementsAre(30));
  EXPECT_THAT(changes({{5.0, 20.0, ByHand::kNone, ByHand::kNone}}),
              ::testing::ElementsAre(10, 30));
}

}  // namespace
}  // namespace mle
