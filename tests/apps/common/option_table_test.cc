#include "apps/common/option_table.h"

#include <limits>
#include <string>
#include <vector>

#include "apps/common/flag_parser.h"
#include "apps/common/help_text.h"
#include "gflags/gflags.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"

namespace mle {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

enum class Rule { kFirst, kSecond };

struct Settings {
  bool draw = true;
  int order = 3;
  std::uint64_t seed = 1;
  double level = 0.1;
  std::string out = "results";
  Rule rule = Rule::kSecond;
  std::vector<std::string> files;
  std::vector<double> times;
  double limit = std::numeric_limits<double>::infinity();
  Eigen::VectorXd output_weight;
  Eigen::MatrixXd move_weight;
  Eigen::VectorXd max_input;
};

// gflags keeps flags for ever, so fields and table live as long.
struct Bound {
  Bound() {
    table.Add("Shape",
              {{"draw", &settings.draw, "Draws."},
               {"order", &settings.order, "Order.", "samples", AtLeast(1)},
               {"seed", &settings.seed, "Seed."},
               {"level", &settings.level, "Level.", "", kProbability}});
    table.Add("Texts",
              {{"out", &settings.out, "Folder."},
               {"rule",
                OneOf<Rule>(&settings.rule, {{"first", Rule::kFirst, "the one"},
                                             {"second", Rule::kSecond, ""}}),
                "Rule."},
               {"files", Words(&settings.files), "Files."},
               {"times", Numbers(&settings.times), "Times."},
               {"limit", ZeroForInfinity(&settings.limit), "Limit."}});
    table.Add(
        "Channels",
        {{"output_weight", ForEachOutput(&settings.output_weight, "0.2"),
          "Weight.", "", kNotNegative},
         {"move_weight", ForEachInput(&settings.move_weight, "1"), "Weight."},
         {"max_input", LimitOfEachInput(&settings.max_input, kInfinity),
          "Limits."}});
    table.PutFirst({"rule", "order"});
    table.RegisterFlags();
  }

  Settings settings;
  OptionTable table;
};

class OptionTableTest : public ::testing::Test {
 protected:
  absl::Status Give(const std::vector<std::string>& arguments) {
    ParsedFlags parsed;
    MLE_RETURN_IF_ERROR(ParseFlags(arguments, parsed));
    return bound_.table.Read();
  }

  void ExpectRefused(const std::string& argument, const std::string& wanted) {
    const gflags::FlagSaver saver;
    const absl::Status status = Give({argument});
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << argument;
    EXPECT_THAT(std::string(status.message()), HasSubstr(argument + ": "));
    EXPECT_THAT(std::string(status.message()), HasSubstr(wanted));
  }

  static Bound& bound_;
  const Settings& settings_ = bound_.settings;
  gflags::FlagSaver saver_;  // puts all flags back
};

Bound& OptionTableTest::bound_ = *new Bound;

ProcessModel TwoByThree() {
  return ProcessModel("tank", "min", {{"a", ""}, {"b", ""}, {"c", ""}},
                      {{"y", ""}, {"z", ""}});
}

TEST_F(OptionTableTest, FieldsKeepTheirDefaults) {
  ASSERT_TRUE(Give({}).ok());
  EXPECT_EQ(settings_.order, 3);
  EXPECT_EQ(settings_.rule, Rule::kSecond);
  EXPECT_EQ(settings_.limit, std::numeric_limits<double>::infinity());
  EXPECT_THAT(
      bound_.table.Values(),
      ::testing::Contains(std::pair<std::string, std::string>("level", "0.1")));
}

TEST_F(OptionTableTest, FlagsReachTheirFields) {
  ASSERT_TRUE(Give({"--nodraw", "--order=7", "--seed=18446744073709551615",
                    "--level=0.5", "--out=x", "--rule=first", "--files=a, b",
                    "--times=1,2.5", "--limit=4"})
                  .ok());
  EXPECT_FALSE(settings_.draw);
  EXPECT_EQ(settings_.order, 7);
  EXPECT_EQ(settings_.seed, 18446744073709551615u);
  EXPECT_EQ(settings_.level, 0.5);
  EXPECT_EQ(settings_.out, "x");
  EXPECT_EQ(settings_.rule, Rule::kFirst);
  EXPECT_THAT(settings_.files, ElementsAre("a", "b"));
  EXPECT_THAT(settings_.times, ElementsAre(1.0, 2.5));
  EXPECT_EQ(settings_.limit, 4.0);
}

TEST_F(OptionTableTest, ValuesForChannelsFitTheModel) {
  ASSERT_TRUE(Give({"--output_weight=1,2", "--max_input=none"}).ok());
  ASSERT_TRUE(bound_.table.FitTo(TwoByThree()).ok());
  EXPECT_THAT(settings_.output_weight, ElementsAre(1.0, 2.0));
  EXPECT_EQ(settings_.move_weight, Eigen::MatrixXd::Identity(3, 3));
  EXPECT_THAT(settings_.max_input, ::testing::SizeIs(3));
  EXPECT_EQ(settings_.max_input[2], std::numeric_limits<double>::infinity());

  ASSERT_TRUE(Give({"--output_weight=1,2,3"}).ok());
  const absl::Status status = bound_.table.FitTo(TwoByThree());
  EXPECT_THAT(std::string(status.message()),
              HasSubstr("--output_weight=1,2,3: 3 values"));
}

TEST_F(OptionTableTest, RefusalsNameOptionValueAndWhatIsRight) {
  ExpectRefused("--order=0", "whole number ≥ 1");
  ExpectRefused("--level=1", "in (0, 1)");
  ExpectRefused("--level=nan", "finite number in (0, 1)");
  ExpectRefused("--rule=third", "choose from first and second");
  ExpectRefused("--rule=secnod", "did you mean 'second'?");
  ExpectRefused("--times=1,x", "'x' is not a number");
  ExpectRefused("--limit=few", "'few' is not a number");
  ExpectRefused("--output_weight=1,-2", "'-2' must be ≥ 0");
  ExpectRefused("--output_weight=", "'' is not a number");
  ExpectRefused("--max_input=1,,2", "'' is not a number");
  ExpectRefused("--move_weight=none", "'none' is not a number");
}

TEST_F(OptionTableTest, FullHelpHasGroupsDefaultsUnitsAndRanges) {
  const std::string help = FullHelp("Draws.", bound_.table);
  EXPECT_THAT(help, HasSubstr("\nShape\n  --draw [true]\n      Draws.\n"));
  EXPECT_THAT(help, HasSubstr("  --order [3] samples, ≥ 1\n"));
  EXPECT_THAT(help, HasSubstr("  --level [0.1] in (0, 1)\n"));
  EXPECT_THAT(help, HasSubstr("Rule. One of first (the one), second.\n"));
  EXPECT_THAT(help, HasSubstr("  --limit [0]\n"));
  EXPECT_THAT(help, HasSubstr("\nEvery command\n  --flagfile []\n"));
}

TEST_F(OptionTableTest, ShortHelpHasWhatWasPutFirstInThatOrder) {
  const std::string help = ShortHelp("Draws.", bound_.table);
  EXPECT_THAT(help, HasSubstr("  --rule   Rule."));
  EXPECT_THAT(help, HasSubstr("  --order  Order. [3]\n"));
  EXPECT_LT(help.find("--rule"), help.find("--order"));
  EXPECT_THAT(help, Not(HasSubstr("--level")));
  EXPECT_THAT(help, HasSubstr("--help=all: all 15 flags"));
}

TEST_F(OptionTableTest, HelpOnAWordHasTheFlagsWithIt) {
  const auto help = HelpOn("weight", bound_.table);
  ASSERT_TRUE(help.ok());
  EXPECT_THAT(*help, HasSubstr("--output_weight"));
  EXPECT_THAT(*help, HasSubstr("--move_weight"));
  EXPECT_THAT(*help, Not(HasSubstr("--order")));
  const auto none = HelpOn("ordre", bound_.table);
  EXPECT_EQ(none.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(none.status().message()),
              HasSubstr("did you mean 'order'?"));
}

TEST_F(OptionTableTest, TheManualPageEscapesWhatTroffWouldRead) {
  const std::string page = ManualPage(
      "draw", "1.2", "Draws a line: well.\n\n  draw --order=3", bound_.table);
  EXPECT_THAT(page, HasSubstr(".SH NAME\ndraw \\- draws a line\n"));
  EXPECT_THAT(page, HasSubstr(".EX\n  draw \\-\\-order=3\n.EE\n"));
  EXPECT_THAT(page, HasSubstr(".SS Channels\n"));
  EXPECT_THAT(page, HasSubstr("\\fB\\-\\-order\\fR (default 3; samples, ≥ 1)"));
}

TEST_F(OptionTableTest, CompletionKnowsFlagsSwitchesAndValues) {
  const std::string script = BashCompletion("draw", bound_.table);
  EXPECT_THAT(script, HasSubstr(" --nodraw "));
  EXPECT_THAT(script, HasSubstr(" --order= "));
  EXPECT_THAT(script, HasSubstr("--rule) words=\"first second\" ;;"));
  EXPECT_THAT(script, HasSubstr("complete -F _draw draw"));
}

TEST(ReadableNumberTest, IsTheShortestTextThatReadsAlike) {
  EXPECT_EQ(ReadableNumber(1e-6), "1e-06");
  EXPECT_EQ(ReadableNumber(0.1), "0.1");
  EXPECT_EQ(ReadableNumber(0.1 + 0.2), "0.30000000000000004");
}

}  // namespace
}  // namespace mle
