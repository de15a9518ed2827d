#include "apps/report/gnuplot.h"

#include <sys/stat.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "apps/report/text.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/file.h"
#include "tests/apps/report/markup.h"

namespace mle::report {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// A folder of its own for a test, gone afterwards.
class Folder {
 public:
  Folder() {
    std::string name = (fs::temp_directory_path() / "mle_XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~Folder() { fs::remove_all(path_); }
  std::string operator/(const std::string& name) const {
    return (path_ / name).string();
  }

  std::string Program(const std::string& name, const std::string& script) {
    std::ofstream(*this / name) << "#!/bin/sh\n" << script << "\n";
    chmod((*this / name).c_str(), 0755);
    return *this / name;
  }

 private:
  fs::path path_;
};

// The variable PATH, put back at the end of the test.
class Path {
 public:
  explicit Path(const std::string& value) {
    if (const char* old = std::getenv("PATH")) old_ = old;
    setenv("PATH", value.c_str(), 1);
  }
  ~Path() { setenv("PATH", old_.c_str(), 1); }

 private:
  std::string old_;
};

Figure Example() {
  Figure figure{.width_cm = 17.0, .height_cm = 6.0, .columns = 2};
  for (const char* name : {"gain", "delay"}) {
    Panel& panel = figure.AddPanel(name);
    panel.x = {.label = "λ", .log = true};
    panel.y = {.label = "E", .log = true};
    Series series =
        MakeSeries(Role::kCorrected, "corrected", {1e-6, 1e-5, 1e-4, 0.0, 1e-2},
                   {100.0, 8.0, 9.0, kNaN, 19363.0});
    series.lower = {90.0, 7.0, 8.0, 1.0, 1e4};
    series.upper = {110.0, 9.0, 10.0, 2.0, 2e4};
    panel.series.push_back(series);
    panel.lines.push_back(HorizontalLine(Role::kInitial, "initial", 19363.0));
    panel.markers.push_back(MakeMarker(Role::kChosen, "chosen λ", 1e-4, 9.0));
    panel.markers.push_back(MakeMarker(Role::kBest, "best λ", 1e-5, 8.0));
  }
  return figure;
}

Figure Labelled(const std::string& label) {
  Figure figure{.width_cm = 40.0};
  Panel& panel = figure.AddPanel(label);
  panel.series.push_back(
      MakeSeries(Role::kTrue, label, {0.0, 1.0}, {0.0, 1.0}));
  return figure;
}

TEST(RenderFigure, SvgIsWellFormedAndHasEveryLabel) {
  const auto svg = RenderFigure(Example(), Format::kSvg);
  ASSERT_TRUE(svg.ok()) << svg.status();
  const Markup markup = ParseMarkup(*svg);
  ASSERT_EQ(markup.error, "");
  EXPECT_EQ(markup.elements[0].name, "svg");
  // 17 cm × 6 cm at 96 dots per inch.
  EXPECT_EQ(markup.elements[0].attributes.at("width"), "643");
  EXPECT_EQ(markup.elements[0].attributes.at("height"), "227");
  const auto texts = markup.Texts("text");
  for (const char* label : {"gain", "delay", "λ", "E", "corrected", "initial",
                            "chosen λ", "best λ", "10⁻⁶", "10³"}) {
    EXPECT_THAT(texts, Contains(HasSubstr(label))) << label;
  }
  EXPECT_EQ(markup.Count("script"), 0);
}

TEST(RenderFigure, PngHasTheSizeAskedFor) {
  const auto png =
      RenderFigure(Example(), Format::kPng, {.png_dots_per_inch = 150.0});
  ASSERT_TRUE(png.ok()) << png.status();
  ASSERT_EQ(png->substr(0, 8), "\x89PNG\r\n\x1a\n");
  ASSERT_EQ(png->substr(12, 4), "IHDR");
  const auto number = [&](std::size_t at) {
    int value = 0;
    for (std::size_t i = at; i < at + 4; ++i) {
      value = 256 * value + static_cast<unsigned char>((*png)[i]);
    }
    return value;
  };
  EXPECT_EQ(number(16), 1004);  // 17 / 2.54 · 150 = 1003.9
  EXPECT_EQ(number(20), 354);   // 6 / 2.54 · 150 = 354.3
}

TEST(RenderFigure, PdfHasTheSizeAskedForAndNoDate) {
  const auto pdf = RenderFigure(Example(), Format::kPdf);
  ASSERT_TRUE(pdf.ok()) << pdf.status();
  EXPECT_THAT(*pdf, HasSubstr("%%EOF"));
  // 17 cm = 481.89 pt, 6 cm = 170.08 pt; gnuplot cuts off to whole points.
  const std::size_t at = pdf->find("/MediaBox");
  ASSERT_NE(at, std::string::npos);
  double box[4] = {};
  ASSERT_EQ(std::sscanf(pdf->c_str() + at, "/MediaBox [ %lf %lf %lf %lf", box,
                        box + 1, box + 2, box + 3),
            4);
  EXPECT_NEAR(box[2], 481.89, 1.0);
  EXPECT_NEAR(box[3], 170.08, 1.0);
  EXPECT_THAT(*pdf, HasSubstr("(D:20000101000000"));
}

TEST(RenderFigure, SameFigureSameBytes) {
  for (const Format format : {Format::kSvg, Format::kPng, Format::kPdf}) {
    const auto first = RenderFigure(Example(), format);
    ASSERT_TRUE(first.ok()) << first.status();
    setenv("TZ", "Asia/Tokyo", 1);
    const auto second = RenderFigure(Example(), format);
    unsetenv("TZ");
    ASSERT_TRUE(second.ok()) << second.status();
    EXPECT_TRUE(*first == *second) << static_cast<int>(format);
  }
}

TEST(RenderFigure, LabelsAreTakenLiterally) {
  const Folder folder;
  const std::string file = folder / "made";
  const std::string touch = "touch " + file;
  for (const std::string& label :
       std::vector<std::string>{"'; system('" + touch + "'); print '",
                                "`" + touch + "`",
                                "$(" + touch + ")",
                                "x'\nsystem '" + touch + "'\n",
                                "\"\nsystem(\"" + touch + "\")\n",
                                "x\\",
                                "x\\'",
                                "'",
                                "''",
                                "\"",
                                "@macro",
                                "%d %s %g",
                                "a_1^2 {/Symbol a} ~b{c} &{d}",
                                "# no comment",
                                "<script>alert(1)</script>",
                                "]]> & &amp; </text></svg>",
                                "EOD",
                                "😀 温度 é λ",
                                "\xff\xfe broken",
                                "\x1b[31m red"}) {
    const auto svg = RenderFigure(Labelled(label), Format::kSvg);
    ASSERT_TRUE(svg.ok()) << label << ": " << svg.status();
    const Markup markup = ParseMarkup(*svg);
    EXPECT_EQ(markup.error, "") << label;
    EXPECT_EQ(markup.Count("script"), 0) << label;
    // In the legend and in the title, which also stand in <tspan>s.
    std::vector<std::string> texts = markup.Texts("text");
    for (const std::string& text : markup.Texts("tspan")) texts.push_back(text);
    const std::string shown = CleanText(label);
    EXPECT_THAT(texts, Contains(shown).Times(2)) << label;
    EXPECT_FALSE(fs::exists(file)) << label;
  }
}

TEST(RenderFigure, LabelsHarmNoOtherFormat) {
  const Figure figure =
      Labelled("'`touch x`\\ \n system('id') {/*9 _^@&~} <b> %d 😀");
  for (const Format format : {Format::kPng, Format::kPdf}) {
    EXPECT_TRUE(RenderFigure(figure, format).ok());
  }
}

TEST(RenderFigure, DrawsWhatHasNoData) {
  Figure figure;
  figure.columns = 3;
  figure.AddPanel("nothing");
  figure.AddPanel("NaN").series.push_back(
      MakeSeries(Role::kTrue, "t", {1.0, 2.0}, {kNaN, kNaN}));
  figure.AddPanel("one").series.push_back(
      MakeSeries(Role::kTrue, "t", {1.0}, {1.0}));
  for (const Format format : {Format::kSvg, Format::kPng, Format::kPdf}) {
    const auto picture = RenderFigure(figure, format);
    EXPECT_TRUE(picture.ok()) << picture.status();
  }
}

TEST(RenderFigure, ExtremesAreDrawn) {
  Figure figure;
  figure.columns = 2;
  for (const bool log : {false, true}) {
    Panel& panel = figure.AddPanel("extremes");
    panel.x.log = panel.y.log = log;
    panel.series.push_back(MakeSeries(Role::kTrue, "t", {1e-150, 1.0, 1e150},
                                      {-1e199, 1e-199, 1e199}));
  }
  const auto picture = RenderFigure(figure, Format::kSvg);
  ASSERT_TRUE(picture.ok()) << picture.status();
  EXPECT_EQ(ParseMarkup(*picture).error, "");
}

TEST(RenderFigure, SaysHowToInstallGnuplot) {
  const Folder empty;
  const Path path(empty / "");
  const auto picture = RenderFigure(Example(), Format::kSvg);
  EXPECT_EQ(picture.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(picture.status().message(),
            "gnuplot is not installed: apt-get install gnuplot-nox; the "
            "figures were not drawn");
}

TEST(RenderFigure, PassesOnWhyGnuplotFailed) {
  Folder folder;
  RenderOptions options{
      .program =
          folder.Program("fails", "echo 'unknown terminal type' >&2; exit 3")};
  auto picture = RenderFigure(Example(), Format::kSvg, options);
  EXPECT_EQ(picture.status().code(), absl::StatusCode::kInternal);
  EXPECT_THAT(std::string(picture.status().message()),
              HasSubstr("(exit code 3): unknown terminal type"));

  options.program = folder.Program("dies", "kill -9 $$");
  picture = RenderFigure(Example(), Format::kSvg, options);
  EXPECT_THAT(std::string(picture.status().message()),
              HasSubstr("(exit code 137): it gave no reason"));

  options.program = folder.Program("breaks_off", "echo '<?xml ?><svg>'");
  EXPECT_FALSE(RenderFigure(Example(), Format::kSvg, options).ok());

  options.program = folder / "not_executable";
  std::ofstream(options.program) << "no program";
  EXPECT_EQ(RenderFigure(Example(), Format::kSvg, options).status().code(),
            absl::StatusCode::kInternal);
}

TEST(RenderFigure, RefusesBadInput) {
  EXPECT_EQ(RenderFigure(Figure(), Format::kSvg).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(RenderFigure(Example(), Format::kPng, {.png_dots_per_inch = 1e9})
                .status()
                .code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(WriteFigure, WritesTheFormatsAskedFor) {
  const Folder folder;
  ASSERT_TRUE(
      WriteFigure(Example(), folder / "e", {Format::kSvg, Format::kPdf}).ok());
  EXPECT_EQ(*ReadFile(folder / "e.svg"),
            *RenderFigure(Example(), Format::kSvg));
  EXPECT_EQ(*ReadFile(folder / "e.pdf"),
            *RenderFigure(Example(), Format::kPdf));
  EXPECT_FALSE(fs::exists(folder / "e.png"));
  EXPECT_FALSE(
      WriteFigure(Example(), folder / "no/such/folder/e", {Format::kSvg}).ok());
}

}  // namespace
}  // namespace mle::report
