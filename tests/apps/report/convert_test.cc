
#include <sys/stat.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "apps/report/drawing.h"
#include "apps/report/figure.h"
#include "apps/report/svg.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/file.h"
#include "tests/mle/base/scratch_folder.h"

namespace mle::report {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class Folder : public ScratchFolder {
 public:
  std::string Program(const std::string& name, const std::string& script) {
    const std::string path = Write(name, "#!/bin/sh\n" + script + "\n");
    chmod(path.c_str(), 0755);
    return path;
  }
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

std::string Picture() {
  Figure figure{.width_cm = 17.0, .height_cm = 6.0};
  figure.AddPanel("<\"温度' 😀>")
      .series.push_back(
          MakeSeries(Role::kCorrected, "λ", {0.0, 1.0}, {0.0, 1.0}));
  return *SvgFile(figure, "title", "description");
}

TEST(ConvertSvg, PngHasTheSizeAskedFor) {
  const auto png =
      ConvertSvg(Picture(), Format::kPng, {.png_dots_per_inch = 150.0});
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
  EXPECT_NEAR(number(16), 1003.9, 1.0);  // 17 / 2.54 · 150
  EXPECT_NEAR(number(20), 354.3, 1.0);   // 6 / 2.54 · 150
}

TEST(ConvertSvg, PdfHasTheSizeAskedForAndNoDate) {
  const auto pdf = ConvertSvg(Picture(), Format::kPdf);
  ASSERT_TRUE(pdf.ok()) << pdf.status();
  EXPECT_THAT(*pdf, HasSubstr("%%EOF"));
  // 17 cm = 481.89 pt, 6 cm = 170.08 pt.
  const std::size_t at = pdf->find("/MediaBox");
  ASSERT_NE(at, std::string::npos);
  double box[4] = {};
  ASSERT_EQ(std::sscanf(pdf->c_str() + at, "/MediaBox [ %lf %lf %lf %lf", box,
                        box + 1, box + 2, box + 3),
            4);
  EXPECT_NEAR(box[2], 481.89, 0.1);
  EXPECT_NEAR(box[3], 170.08, 0.1);
  EXPECT_THAT(*pdf, HasSubstr("(20000101000000"));
}

TEST(ConvertSvg, SameFigureSameBytes) {
  for (const Format format : {Format::kPng, Format::kPdf}) {
    const auto first = ConvertSvg(Picture(), format);
    ASSERT_TRUE(first.ok()) << first.status();
    setenv("TZ", "Asia/Tokyo", 1);
    const auto second = ConvertSvg(Picture(), format);
    unsetenv("TZ");
    ASSERT_TRUE(second.ok()) << second.status();
    EXPECT_TRUE(*first == *second) << static_cast<int>(format);
  }
}

TEST(ConvertSvg, SaysHowToInstallTheProgram) {
  const Folder empty;
  const Path path(empty / "");
  const auto picture = ConvertSvg(Picture(), Format::kPng);
  EXPECT_EQ(picture.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(picture.status().message()),
              HasSubstr("rsvg-convert is not installed (apt-get install"));
}

TEST(ConvertSvg, KillsAProgramThatHangs) {
  Folder folder;
  const ConvertOptions options{
      .program = folder.Program(
          "hangs", "echo $$ >" + (folder / "id") + "; exec sleep 100"),
      .time_limit = absl::Milliseconds(300)};
  const absl::Time start = absl::Now();
  const auto picture = ConvertSvg(Picture(), Format::kPdf, options);
  EXPECT_LT(absl::Now() - start, absl::Seconds(20));
  EXPECT_EQ(picture.status().code(), absl::StatusCode::kDeadlineExceeded);
  EXPECT_THAT(std::string(picture.status().message()),
              HasSubstr("hangs did not end within 300ms"));
  const int id = std::stoi(*ReadFile(folder / "id"));
  EXPECT_EQ(kill(id, 0), -1) << "it still runs";
}

TEST(DrawFigures, AsksAProgramThatHangsOnlyOnce) {
  Folder folder;
  const ConvertOptions options{
      .program = folder.Program(
          "hangs", "echo x >>" + (folder / "calls") + "; exec sleep 100"),
      .time_limit = absl::Milliseconds(300)};
  NamedFigure named{"n", "c", "a", Figure()};
  named.figure.AddPanel("");
  const auto drawn = DrawFigures({named, named, named}, 1, options);
  ASSERT_EQ(drawn.size(), 3u);
  for (const DrawnFigure& one : drawn) {
    EXPECT_TRUE(one.svg.ok());
    EXPECT_TRUE(absl::IsDeadlineExceeded(one.png.status()));
    EXPECT_TRUE(absl::IsDeadlineExceeded(one.pdf.status()));
  }
  EXPECT_EQ(*ReadFile(folder / "calls"), "x\n");
  std::vector<std::pair<std::string, std::string>> files;
  const std::vector<std::string> missing = AddPictures(drawn, files);
  EXPECT_EQ(files.size(), 3u);  // the three SVG
  EXPECT_THAT(missing, ElementsAre("n.png", "n.pdf", "n.png", "n.pdf", "n.png",
                                   "n.pdf"));
}

TEST(ConvertSvg, PassesOnWhyTheProgramFailed) {
  Folder folder;
  ConvertOptions options{
      .program =
          folder.Program("fails", "echo 'unknown terminal type' >&2; exit 3")};
  auto picture = ConvertSvg(Picture(), Format::kPng, options);
  EXPECT_EQ(picture.status().code(), absl::StatusCode::kInternal);
  EXPECT_THAT(std::string(picture.status().message()),
              HasSubstr("(exit code 3): unknown terminal type"));

  options.program = folder.Program("dies", "kill -9 $$");
  picture = ConvertSvg(Picture(), Format::kPng, options);
  EXPECT_THAT(std::string(picture.status().message()),
              HasSubstr("(exit code 137): it gave no reason"));

  options.program = folder.Program("breaks_off", "printf '%%PDF-1.5'");
  EXPECT_FALSE(ConvertSvg(Picture(), Format::kPdf, options).ok());

  options.program = folder / "not_executable";
  std::ofstream(options.program) << "no program";
  EXPECT_EQ(ConvertSvg(Picture(), Format::kPng, options).status().code(),
            absl::StatusCode::kInternal);
}

TEST(ConvertSvg, RefusesBadInput) {
  EXPECT_EQ(ConvertSvg("no picture", Format::kPng).status().code(),
            absl::StatusCode::kInternal);
  EXPECT_EQ(ConvertSvg(Picture(), Format::kPng, {.png_dots_per_inch = 1e9})
                .status()
                .code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace mle::report
