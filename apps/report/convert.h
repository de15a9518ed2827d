// Figures for papers and slides: SVG as PNG and PDF, converted by the program
// rsvg-convert (librsvg), which is run without a shell.

#ifndef APPS_REPORT_CONVERT_H_
#define APPS_REPORT_CONVERT_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "absl/time/time.h"

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

}  // namespace mle::report

#endif  // APPS_REPORT_CONVERT_H_
