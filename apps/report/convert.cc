#include "apps/report/convert.h"

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "apps/report/process.h"
#include "apps/report/text.h"
#include "mle/base/status.h"

namespace mle::report {
namespace {

bool IsWhole(Format format, std::string_view picture) {
  if (format == Format::kPng) {
    return picture.starts_with("\x89PNG\r\n\x1a\n") &&
           picture.find("IEND") != std::string_view::npos;
  }
  return picture.starts_with("%PDF-") &&
         picture.find("%%EOF") != std::string_view::npos;
}

// The program's error output, shortened to fit a message.
std::string Complaint(const std::string& err) {
  constexpr std::size_t kMost = 400;
  const std::string text = CleanText(err.substr(0, kMost));
  const std::size_t first = text.find_first_not_of(' ');
  if (first == std::string::npos) return "it gave no reason";
  return text.substr(first, text.find_last_not_of(' ') + 1 - first);
}

}  // namespace

absl::StatusOr<std::string> ConvertSvg(std::string_view svg, Format format,
                                       const ConvertOptions& options) {
  const double dots = options.png_dots_per_inch;
  if (!(dots >= 30.0 && dots <= 1200.0)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "png_dots_per_inch is ", dots, "; it must lie in [30, 1200]"));
  }
  std::vector<std::string> arguments = {"--format=pdf"};
  if (format == Format::kPng) {
    arguments = {"--format=png", absl::StrCat("--dpi-x=", dots),
                 absl::StrCat("--dpi-y=", dots)};
  }
  // PDF holds the time of drawing: the same for every drawing.
  absl::StatusOr<ProcessResult> run =
      RunProcess(options.program, arguments, svg,
                 {.time_limit = options.time_limit,
                  .variables = {"SOURCE_DATE_EPOCH=946684800"}});
  if (absl::IsNotFound(run.status())) {
    return absl::FailedPreconditionError(
        absl::StrCat(options.program,
                     " is not installed (apt-get install librsvg2-bin): the "
                     "figures were written as SVG, not as PNG and PDF"));
  }
  if (absl::IsDeadlineExceeded(run.status())) {
    return absl::DeadlineExceededError(
        absl::StrCat(run.status().message(),
                     ": the figures were written as SVG, not all as PNG and "
                     "PDF"));
  }
  MLE_RETURN_IF_ERROR(run.status());
  if (run->exit_code != 0 || !IsWhole(format, run->out)) {
    return absl::InternalError(
        absl::StrCat(options.program, " did not convert a figure (exit code ",
                     run->exit_code, "): ", Complaint(run->err)));
  }
  return std::move(run->out);
}

}  // namespace mle::report
