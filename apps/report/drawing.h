// The figures of a page, and the files of them beside it.
//
//   return WriteReport(folder, MakeFigures(result), 0,
//                      {{"result.json", FormatResult(result)}},
//                      [&](const std::vector<DrawnFigure>& drawn) { … });

#ifndef APPS_REPORT_DRAWING_H_
#define APPS_REPORT_DRAWING_H_

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "apps/report/figure.h"
#include "apps/report/html.h"

namespace mle::report {

enum class Format { kPng, kPdf };

struct ConvertOptions {
  std::string program = "rsvg-convert";           // sought in PATH
  double png_dots_per_inch = 200.0;               // [30, 1200]
  absl::Duration time_limit = absl::Seconds(30);  // then it is killed
};

// The bytes of the picture; the same SVG gives the same. FailedPrecondition if
// the program is not installed, DeadlineExceeded if it hangs, Internal with its
// own words if it fails.
absl::StatusOr<std::string> ConvertSvg(std::string_view svg, Format format,
                                       const ConvertOptions& options = {});

struct NamedFigure {
  std::string name = {};     // of its files, without extension
  std::string caption = {};  // says what is shown, in a page
  // The same to those who cannot see it; empty: the caption.
  std::string alt = {};
  Figure figure = {};
};

// The file of each picture, or why there is none.
struct DrawnFigure {
  NamedFigure named;
  absl::StatusOr<std::string> svg;
  absl::StatusOr<std::string> png;
  absl::StatusOr<std::string> pdf;
};

// In the order given, on `threads` threads (0: one for each processor). PNG and
// PDF need a program; when that hangs once, it is not asked again.
std::vector<DrawnFigure> DrawFigures(std::vector<NamedFigure> figures,
                                     int threads,
                                     const ConvertOptions& options = {});

// Adds name and content of every picture there is to `files`. The first reason
// why one is missing becomes a warning on standard error: what could not be
// drawn leaves the results as good as they are. Returns the names of those
// missing: files of that name are of a former run.
std::vector<std::string> AddPictures(
    const std::vector<DrawnFigure>& drawn,
    std::vector<std::pair<std::string, std::string>>& files);

// Draws the figures and writes their files, `files` and report.html, which
// `page` makes of the figures drawn, into `folder`: all or none.
absl::Status WriteReport(
    const std::string& folder, std::vector<NamedFigure> figures, int threads,
    std::vector<std::pair<std::string, std::string>> files,
    const std::function<std::string(const std::vector<DrawnFigure>&)>& page);

bool HasFigure(const std::vector<DrawnFigure>& drawn, std::string_view name);

// The figure of that name; nothing if there is none.
void AddFigure(const std::vector<DrawnFigure>& drawn, std::string_view name,
               HtmlPage& page);

}  // namespace mle::report

#endif  // APPS_REPORT_DRAWING_H_
