#include "mle/exchange/element_table.h"

#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

constexpr char kTable[] =
    "name,Heated tank\n"
    "time unit,min\n"
    "input,steam,t/h\n"
    "input,inflow,m3/h,disturbance\n"
    "output,temperature,degC\n"
    "output,pressure,bar\n"
    "output,input,gain,time constant,second time constant,lead,dead time\n"
    "temperature,steam,8,12,,,1.5\n"
    "pressure,inflow,0.37,3,7,-2.5,0.25\n"
    "temperature,inflow,-0.5,9.1,,,0\n"
    "pressure,steam,0.1,0,,,2\n";

ElementTable ParsedTable(const std::string& text) {
  const absl::StatusOr<ElementTable> table =
      ParseElementTable(text, "tank.csv");
  EXPECT_TRUE(table.ok()) << table.status();
  return table.ok() ? *table : ElementTable();
}

TEST(ElementTable, ReadsElements) {
  const ProcessModel process = ParsedTable(kTable).Process();
  EXPECT_EQ(process.name(), "Heated tank");
  EXPECT_EQ(process.inputs()[1].role, InputRole::kDisturbance);
  const TransferFunction& first = process.element(0, 0);
  EXPECT_TRUE(first.IsFirstOrder());
  EXPECT_EQ(first.StaticGain(), 8.0);
  EXPECT_EQ(first.TimeConstant(), 12.0);
  EXPECT_EQ(first.delay(), 1.5);
  const TransferFunction& second = process.element(1, 1);
  EXPECT_EQ(second.denominator(), (std::vector<double>{21.0, 10.0, 1.0}));
  EXPECT_EQ(second.numerator(), (std::vector<double>{-2.5 * 0.37, 0.37}));
  EXPECT_EQ(process.element(1, 0).denominator(), std::vector<double>{1.0});
}

// The shortest table that a person would type; columns in any order.
TEST(ElementTable, ReadsShortTables) {
  const ElementTable table = ParsedTable(
      "Time unit;s\nGain;Input;Output;Delay;Time_Constant\n1,5;u;y;0;3\n");
  EXPECT_EQ(table.channels.name(), "tank");
  EXPECT_EQ(table.channels.time_unit(), "s");
  EXPECT_EQ(table.rows[0].gain, 1.5);
  EXPECT_EQ(table.rows[0].time_constant, 3.0);
  EXPECT_FALSE(table.has_lead);
}

TEST(ElementTable, ComesBackAsItWas) {
  const ElementTable table = ParsedTable(kTable);
  EXPECT_EQ(FormatElementTable(table), kTable);
  EXPECT_EQ(FormatElementTable(WithElements(table, table.Process())), kTable);
}

// Names and units as spreadsheets have them, and levels.
TEST(ElementTable, ChannelsMayHaveTransforms) {
  const std::string lines =
      "transform,steam,equal_percentage,rangeability,50,closed,0,open,100,at,"
      "40\ntransform,pressure,piecewise_linear,point,0,0,point,2,5,point,9,6.5,"
      "at,1\n";
  const std::string text = absl::StrReplaceAll(
      kTable, {{"output,input,gain", lines + "output,input,gain"}});
  const ElementTable table = ParsedTable(text);
  const Transform& steam = table.channels.inputs()[0].transform;
  EXPECT_EQ(steam.kind, TransformKind::kEqualPercentage);
  EXPECT_EQ(steam.rangeability, 50.0);
  EXPECT_EQ(steam.at, 40.0);
  const Transform& pressure = table.Process().outputs()[1].transform;
  EXPECT_EQ(pressure.points.size(), 3U);
  EXPECT_EQ(pressure.points[2], std::pair(9.0, 6.5));
  EXPECT_EQ(
      ParsedTable(FormatElementTable(table)).channels.inputs()[0].transform,
      steam);
  EXPECT_EQ(
      ParsedTable(FormatElementTable(table)).channels.outputs()[1].transform,
      pressure);
  const auto fault = [&](const std::string& line) {
    const std::string wrong = absl::StrReplaceAll(
        kTable, {{"output,input,gain", line + "\noutput,input,gain"}});
    return std::string(ParseElementTable(wrong, "tank.csv").status().message());
  };
  EXPECT_THAT(fault("transform,flap,log,at,1"),
              HasSubstr("line 7: the transform is of 'flap', which no line"));
  EXPECT_THAT(fault("transform,steam,log,at,0"),
              HasSubstr("line 7: transform of steam: at = 0"));
  EXPECT_THAT(fault("transform,steam,log,at"), HasSubstr("lacks a number"));
  EXPECT_THAT(fault("transform,steam"), HasSubstr("a channel, a kind"));
  EXPECT_THAT(fault("transform,steam,log,at,1,at,2"),
              HasSubstr("line 7, column 6: the key is given twice"));
  EXPECT_THAT(fault("transform,steam,log,kind,1"),
              HasSubstr("line 7, column 4: the key is given twice"));
  EXPECT_THAT(fault("transform,steam,piecewise_linear,points,5,point,1,2"),
              HasSubstr("line 7, column 4: a point is point,x,f"));
  EXPECT_THAT(fault("transform,steam,log,at,1\ntransform,steam,log,at,2"),
              HasSubstr("line 8: a second transform of 'steam'"));
  EXPECT_THAT(fault("transform,steam,log,at,half"),
              HasSubstr("line 7, column 5: 'half' is not a number"));
}

TEST(ElementTable, ReadsTheNamesOfSpreadsheets) {
  const ElementTable table = ParsedTable(
      "time unit,min\nCV,MV,K (cm/%),Tau [min],Theta [min],Type\n"
      "level,valve,-0.4,,0.5,Integrator\nlevel,feed,0.2,3,1,ramp\n"
      "temperature,valve,2,5,1,FOPDT\ntemperature,feed,1,4,1,\n");
  const ProcessModel process = table.Process();
  EXPECT_EQ(process.element(0, 0).denominator(),
            (std::vector<double>{1.0, 0.0}));
  EXPECT_EQ(process.element(0, 0).StaticGain(), -0.4);
  EXPECT_EQ(process.element(0, 1).denominator(),
            (std::vector<double>{3.0, 1.0, 0.0}));
  EXPECT_TRUE(process.element(1, 0).IsFirstOrder());
  const std::string text = FormatElementTable(table);
  EXPECT_THAT(text, HasSubstr("dead time,integrating\n"
                              "level,valve,-0.4,0,0.5,yes\n"));
  EXPECT_THAT(text, HasSubstr("temperature,feed,1,4,1,\n"));
  EXPECT_EQ(FormatElementTable(ParsedTable(text)), text);
}

// The unit of time may stand in the header alone; where it is none, or two, the
// message says so.
TEST(ElementTable, TheHeaderMayHaveTheUnitOfTime) {
  const auto with = [](const std::string& tau, const std::string& theta) {
    return "output,input,gain," + tau + "," + theta + "\ny,u,2,5,1\n";
  };
  EXPECT_EQ(ParsedTable(with("Tau (min)", "dead time")).channels.time_unit(),
            "min");
  EXPECT_EQ(ParsedTable(with("Tau", "Theta [s]")).channels.time_unit(), "s");
  for (const auto& [tau, theta] :
       {std::pair("Tau", "Theta"), std::pair("Tau (min)", "Theta (s)")}) {
    EXPECT_THAT(
        std::string(
            ParseElementTable(with(tau, theta), "a.csv").status().message()),
        HasSubstr("nor have the columns of times the same in brackets"));
  }
}

TEST(ElementTable, ADampingIsForJson) {
  for (const std::string name : {"zeta", "Damping_Ratio", "ζ"}) {
    const std::string text = "time unit,min\noutput,input,gain,tau," + name +
                             ",dead time\ny,u,2,5,0.4,1\n";
    EXPECT_THAT(
        std::string(ParseElementTable(text, "a.csv").status().message()),
        HasSubstr("line 2, column 5: '" + name +
                  "' is a damping, of which a table of elements has none: give "
                  "the model in JSON"));
  }
}

// An integrator with lags of any number is the nearest with one where the form
// has none that is it.
TEST(ElementTable, TimesInAnotherUnitAreRefused) {
  const auto message = [](const std::string& times, const std::string& dead) {
    const std::string text = absl::StrReplaceAll(
        kTable, {{"time constant,second", times + ",second"},
                 {"dead time\n", dead + "\n"}});
    return std::string(ParseElementTable(text, "tank.csv").status().message());
  };
  EXPECT_EQ(message("Tau [minutes]", "theta (min)"), "");
  EXPECT_EQ(message("T1 (lag)", "L"), "");
  EXPECT_THAT(
      message("time constant [s]", "dead time [s]"),
      HasSubstr("line 7, column 4: the time constant is in 's', but the "
                "time unit of the file is 'min'"));
  EXPECT_THAT(message("time constant [min]", "dead time (h)"),
              HasSubstr("the dead time is in 'h'"));
}

TEST(ElementTable, TakesChangedLevels) {
  const ElementTable table = ParsedTable(
      "time unit,min\noutput,input,gain,time constant,dead time,integrating\n"
      "level,valve,-0.4,2,0.5,yes\n");
  ProcessModel corrected = table.Process();
  corrected.element(0, 0) = TransferFunction::Integrator(-0.2, 2.5, 0.75);
  ElementRow row = WithElements(table, corrected).rows[0];
  EXPECT_TRUE(row.integrating);
  EXPECT_EQ(row.gain, -0.2);
  EXPECT_EQ(row.time_constant, 2.5);
  EXPECT_EQ(row.largest_difference, 0.0);
  // 1/s³ + 3/s² + 3/s + 1, times s.
  corrected.element(0, 0) =
      TransferFunction({-0.2}, {1.0, 3.0, 3.0, 1.0, 0.0}, 0.5);
  row = WithElements(table, corrected).rows[0];
  EXPECT_TRUE(row.integrating);
  // The ramp stays: three lags of 1 and the dead time.
  EXPECT_EQ(row.gain, -0.2);
  EXPECT_NEAR(row.time_constant + row.delay, 3.5, 1e-12);
  EXPECT_GT(row.largest_difference, 0.0);
  EXPECT_LT(row.largest_difference, 0.02);
}

// Changed elements of the table's form are written exactly, in their rows.
TEST(ElementTable, TakesChangedElements) {
  const ElementTable table = ParsedTable(kTable);
  ProcessModel corrected = table.Process();
  corrected.element(0, 1) = TransferFunction::FirstOrder(-0.7, 9.1, 0.5);
  // Lags 3 and 7 are 1.5 times as long, and the gain doubles.
  corrected.element(1, 1) = TransferFunction(
      {2.0 * -2.5 * 0.37 * 1.5, 2.0 * 0.37}, {21.0 * 2.25, 15.0, 1.0}, 0.25);
  const ElementTable changed = WithElements(table, corrected);
  ASSERT_EQ(changed.rows.size(), 4U);
  EXPECT_EQ(changed.rows[0].gain, 8.0);
  EXPECT_EQ(changed.rows[2].gain, -0.7);
  EXPECT_EQ(changed.rows[2].delay, 0.5);
  EXPECT_NEAR(changed.rows[1].gain, 0.74, 1e-14);
  EXPECT_NEAR(changed.rows[1].time_constant, 4.5, 1e-13);
  EXPECT_NEAR(changed.rows[1].second_time_constant, 10.5, 1e-13);
  EXPECT_NEAR(changed.rows[1].lead, -3.75, 1e-14);
  for (const ElementRow& row : changed.rows) {
    EXPECT_EQ(row.largest_difference, 0.0);
  }
}

// Numbers that were given keep every digit, those that are new have five.
TEST(ElementTable, NewNumbersAreForTyping) {
  const ElementTable table = ParsedTable(kTable);
  ElementTable changed = table;
  changed.rows[0].gain = 8.0 * 0.651234567;
  changed.rows[0].delay = -1.0 / 3.0;
  const ElementTable rounded = ForTyping(table, changed);
  EXPECT_EQ(rounded.rows[0].gain, 5.2099);
  EXPECT_EQ(rounded.rows[0].delay, -0.33333);
  EXPECT_EQ(rounded.rows[0].time_constant, table.rows[0].time_constant);
  ElementTable fine = table;
  fine.rows[1].gain = 0.123456789;
  EXPECT_EQ(ForTyping(fine, fine).rows[1].gain, 0.123456789);
}

// What the form cannot hold is the nearest that it can, with its difference.
TEST(ElementTable, StatesTheDifferenceOfOtherShapes) {
  const ElementTable table = ParsedTable(kTable);
  ProcessModel corrected = table.Process();
  corrected.element(0, 0) =
      TransferFunction({4.0}, {60.0, 107.0, 52.0, 1.0}, 1.0);
  const ElementTable changed = WithElements(table, corrected);
  const ElementRow& row = changed.rows[0];
  EXPECT_GT(row.largest_difference, 0.0);
  EXPECT_LT(row.largest_difference, 0.05);
  const Eigen::VectorXd wanted = corrected.element(0, 0).StepResponse(0.5, 600);
  const Eigen::VectorXd found = row.Element().StepResponse(0.5, 600);
  EXPECT_NEAR((found - wanted).cwiseAbs().maxCoeff() / 4.0,
              row.largest_difference, 0.01);
  const std::string text = FormatElementTable(changed);
  EXPECT_THAT(text, HasSubstr("dead time,largest difference\n"));
  // The column is no part of the model.
  EXPECT_EQ(ParsedTable(text).rows[0].gain, row.gain);
}

TEST(ElementTable, SaysWhatIsWrong) {
  const std::vector<std::pair<std::vector<std::pair<std::string, std::string>>,
                              std::vector<std::string>>>
      mistakes = {
          {{{"9.1,,,0\n", "9.1,,,0,3\n"}}, {"line 10", "8 fields", "has 7"}},
          {{{"9.1,,,0\n", "9.1\n"}}, {"line 10, column 7", "empty"}},
          {{{"-0.5,9.1", "half,9.1"}}, {"line 10, column 3", "'half'"}},
          {{{"dead time\n", "type\n"}}, {"no column 'dead time'"}},
          {{{"lead,", "type,"}}, {"line 9, column 6", "'-2.5'", "'yes'"}},
          {{{"-0.5,9.1", "-0.5,-9.1"}},
           {"line 10, column 4", "time constant is -9.1"}},
          {{{"9.1,,,0\n", "9.1,,,-1\n"}}, {"line 10, column 7", "dead time"}},
          {{{"temperature,inflow,", "level,inflow,"}},
           {"line 10, column 1", "'level'", "temperature, pressure"}},
          {{{"temperature,inflow,", "temperature,outflow,"}},
           {"line 10, column 2", "'outflow'"}},
          {{{"temperature,inflow,", "temperature,steam,"}},
           {"line 10", "line 8 already"}},
          {{{"pressure,steam,0.1,0,,", "pressure,steam,0.1,0,,3"}},
           {"line 11", "proper"}},
          {{{"lead", "lag"}}, {"line 7, column 6", "'lag'"}},
          {{{"lead", "gain"}}, {"line 7, column 6", "column 3 already"}},
          {{{"dead time", "largest difference"}}, {"line 7", "'dead time'"}},
          {{{"time unit,min", "interval,1"}}, {"time unit,min"}},
          {{{"time unit,min", "time unit,min\ninterval,1"}},
           {"line 3", "'interval'"}}};
  for (const auto& [replaced, named] : mistakes) {
    const std::string bad = absl::StrReplaceAll(kTable, replaced);
    SCOPED_TRACE(bad);
    ASSERT_NE(bad, kTable);
    const absl::StatusOr<ElementTable> table =
        ParseElementTable(bad, "tank.csv");
    ASSERT_FALSE(table.ok());
    EXPECT_THAT(std::string(table.status().message()), HasSubstr("tank.csv: "));
    for (const std::string& name : named) {
      EXPECT_THAT(std::string(table.status().message()), HasSubstr(name));
    }
  }
}

}  // namespace
}  // namespace mle
