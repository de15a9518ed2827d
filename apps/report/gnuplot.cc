#include "apps/report/gnuplot.h"

#include <array>
#include <cmath>
#include <string_view>

#include "absl/strings/str_cat.h"
#include "apps/report/gnuplot_script.h"
#include "apps/report/layout.h"
#include "apps/report/number.h"
#include "apps/report/process.h"
#include "apps/report/text.h"
#include "mle/base/file.h"
#include "mle/base/status.h"

namespace mle::report {
namespace {

constexpr double kPointsPerInch = 72.0;
constexpr double kSvgPixelsPerInch = 96.0;

std::string Extension(Format format) {
  switch (format) {
    case Format::kSvg:
      return ".svg";
    case Format::kPng:
      return ".png";
    case Format::kPdf:
      return ".pdf";
  }
  return "";
}

std::string SizeInPixels(const Layout& layout, double pixels_per_pt) {
  return absl::StrCat(std::lround(layout.width_pt * pixels_per_pt), ",",
                      std::lround(layout.height_pt * pixels_per_pt));
}

// The factors were measured on gnuplot 5.4. A font of size 1 is 1 px in SVG,
// 1/72 in at 96 dots per inch in PNG whatever its resolution, and 4/3 pt in
// PDF; a line of width 1 is 1 px, 1 px and 1/2 pt; a marker of size 1 is 3/4 of
// the font size, 6 px and 6 pt; a dash of length 1 is 0.5, 0.275 and 0.275
// times the width of its line, which in PDF counts as 1 pt at least.
Terminal TerminalOf(Format format, const Figure& figure, const Layout& layout,
                    const RenderOptions& options) {
  Terminal terminal;
  switch (format) {
    case Format::kSvg: {
      const double scale = kSvgPixelsPerInch / kPointsPerInch;
      terminal.name_and_size =
          absl::StrCat("svg size ", SizeInPixels(layout, scale),
                       " fixed background rgb 'white'");
      terminal.font_per_pt = scale;
      terminal.line_per_pt = scale;
      terminal.marker_per_pt = 1.0 / (0.75 * figure.font_size_pt);
      terminal.dash_length = 0.5;
      break;
    }
    case Format::kPng: {
      const double scale = options.png_dots_per_inch / kPointsPerInch;
      terminal.name_and_size =
          absl::StrCat("pngcairo size ", SizeInPixels(layout, scale),
                       " background rgb 'white'");
      terminal.font_per_pt = options.png_dots_per_inch / 96.0;
      terminal.line_per_pt = scale;
      terminal.marker_per_pt = scale / 6.0;
      terminal.dash_length = 0.275;
      break;
    }
    case Format::kPdf:
      terminal.name_and_size =
          absl::StrCat("pdfcairo size ", figure.width_cm, "cm,",
                       figure.height_cm, "cm fontscale 1");
      terminal.font_per_pt = 0.75;
      terminal.line_per_pt = 2.0;
      terminal.marker_per_pt = 1.0 / 6.0;
      terminal.dash_length = 0.275;
      terminal.dash_min_width_pt = 1.0;
      break;
  }
  return terminal;
}

bool IsWhole(Format format, std::string_view picture) {
  switch (format) {
    case Format::kSvg:
      return picture.starts_with("<?xml") &&
             picture.find("</svg>") != std::string_view::npos;
    case Format::kPng:
      return picture.starts_with("\x89PNG\r\n\x1a\n") &&
             picture.find("IEND") != std::string_view::npos;
    case Format::kPdf:
      return picture.starts_with("%PDF-") &&
             picture.find("%%EOF") != std::string_view::npos;
  }
  return false;
}

// `svg` with `to` for every `from` inside a tag; texts stay.
std::string ReplaceInTags(const std::string& svg, std::string_view from,
                          std::string_view to) {
  std::string out;
  std::size_t at = 0;
  while (true) {
    const std::size_t found = svg.find(from, at);
    if (found == std::string::npos) return out + svg.substr(at);
    const std::size_t open = svg.rfind('<', found);
    const std::size_t close = svg.rfind('>', found);
    const bool in_tag = open != std::string::npos &&
                        (close == std::string::npos || close < open);
    out.append(svg, at, found - at);
    out += in_tag ? to : from;
    at = found + from.size();
  }
}

// Viewers without DejaVu Sans take the next font, not one with serifs; the
// lines of markers, 1 px at marker size 1 by gnuplot, are as strong as in the
// other formats.
std::string WithBetterStyle(const std::string& svg, double font_size_pt) {
  const double font_px = font_size_pt * kSvgPixelsPerInch / kPointsPerInch;
  const double marker_line = 1.0 / (0.375 * font_px);  // in marker radii
  const auto attribute = [](double width) {
    return "stroke-width='" + FormatFixed(width, 3) + "'";
  };
  return ReplaceInTags(
      ReplaceInTags(svg, "font-family=\"DejaVu Sans\"",
                    "font-family=\"DejaVu Sans, Verdana, Helvetica, Arial, "
                    "sans-serif\""),
      attribute(marker_line), attribute(1.7 * marker_line));
}

// The time of drawing is the only thing that differs between two runs.
std::string WithoutDate(std::string pdf) {
  constexpr std::string_view kDate = "/CreationDate (D:";
  const std::size_t found = pdf.rfind(kDate);
  if (found == std::string::npos) return pdf;
  for (std::size_t i = found + kDate.size(), digit = 0;
       i < pdf.size() && pdf[i] >= '0' && pdf[i] <= '9' && digit < 14;
       ++i, ++digit) {
    pdf[i] = "20000101000000"[digit];
  }
  return pdf;
}

// What gnuplot said, shortened to fit a message.
std::string Complaint(const std::string& err) {
  constexpr std::size_t kMost = 400;
  const std::string text = CleanText(err.substr(0, kMost));
  const std::size_t first = text.find_first_not_of(' ');
  if (first == std::string::npos) return "it gave no reason";
  return text.substr(first, text.find_last_not_of(' ') + 1 - first);
}

}  // namespace

absl::StatusOr<std::string> RenderFigure(const Figure& figure, Format format,
                                         const RenderOptions& options) {
  const bool good_resolution =
      options.png_dots_per_inch >= 30.0 && options.png_dots_per_inch <= 1200.0;
  if (!good_resolution) {
    return absl::InvalidArgumentError(
        absl::StrCat("png_dots_per_inch is ", options.png_dots_per_inch,
                     "; it must lie in [30, 1200]"));
  }
  MLE_ASSIGN_OR_RETURN(const Layout layout, MakeLayout(figure));
  const std::string script = GnuplotScript(
      figure, layout, TerminalOf(format, figure, layout, options));
  // -d: no start-up files of the user, which could change the look.
  absl::StatusOr<ProcessResult> run =
      RunProcess(options.program, {"-d"}, script);
  if (absl::IsNotFound(run.status())) {
    return absl::FailedPreconditionError(
        absl::StrCat(options.program,
                     " is not installed: apt-get install gnuplot-nox; the "
                     "figures were not drawn"));
  }
  MLE_RETURN_IF_ERROR(run.status());
  if (run->exit_code != 0 || !IsWhole(format, run->out)) {
    return absl::InternalError(
        absl::StrCat(options.program, " did not draw the figure (exit code ",
                     run->exit_code, "): ", Complaint(run->err)));
  }
  if (format == Format::kSvg)
    return WithBetterStyle(run->out, figure.font_size_pt);
  if (format == Format::kPdf) return WithoutDate(std::move(run->out));
  return std::move(run->out);
}

absl::Status WriteFigure(const Figure& figure, const std::string& base_path,
                         const std::vector<Format>& formats,
                         const RenderOptions& options) {
  for (const Format format : formats) {
    MLE_ASSIGN_OR_RETURN(const std::string picture,
                         RenderFigure(figure, format, options));
    MLE_RETURN_IF_ERROR(
        WriteFileAtomically(base_path + Extension(format), picture));
  }
  return absl::OkStatus();
}

}  // namespace mle::report
