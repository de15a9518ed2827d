// Draws figures with gnuplot, run as a process of its own without a shell.
//
// The same figure gives the same bytes. Labels reach gnuplot as literal text:
// nothing in them is read as a command, an escape or markup.
//
//   absl::Status status = WriteFigure(figure, out + "/error_over_lambda",
//                                     {Format::kSvg, Format::kPdf});

#ifndef APPS_REPORT_GNUPLOT_H_
#define APPS_REPORT_GNUPLOT_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/report/figure.h"

namespace mle::report {

enum class Format { kSvg, kPng, kPdf };

struct RenderOptions {
  std::string program = "gnuplot";   // sought in PATH
  double png_dots_per_inch = 200.0;  // [30, 1200]
};

// The bytes of the picture. FailedPrecondition if gnuplot is not installed,
// Internal with gnuplot's own words if it fails, InvalidArgument as
// Figure::Validate.
absl::StatusOr<std::string> RenderFigure(const Figure& figure, Format format,
                                         const RenderOptions& options = {});

// Writes base_path.svg, .png and .pdf, as asked, each whole or not at all.
absl::Status WriteFigure(const Figure& figure, const std::string& base_path,
                         const std::vector<Format>& formats,
                         const RenderOptions& options = {});

}  // namespace mle::report

#endif  // APPS_REPORT_GNUPLOT_H_
