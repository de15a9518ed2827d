#include "apps/report/drawing.h"

#include <array>
#include <iostream>
#include <mutex>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "apps/report/process.h"
#include "apps/report/svg.h"
#include "apps/report/text.h"
#include "mle/base/file.h"
#include "mle/base/parallel.h"
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
    return InvalidArgument("png_dots_per_inch is ", dots,
                           "; it must lie in [30, 1200]");
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

std::vector<DrawnFigure> DrawFigures(std::vector<NamedFigure> figures,
                                     int threads,
                                     const ConvertOptions& options) {
  std::vector<DrawnFigure> drawn(figures.size());
  for (std::size_t i = 0; i < figures.size(); ++i) {
    NamedFigure& named = drawn[i].named;
    named = std::move(figures[i]);
    if (named.alt.empty()) named.alt = named.caption;
    drawn[i].svg = SvgFile(named.figure, named.caption, named.alt);
  }
  constexpr std::array kFormats = {Format::kPng, Format::kPdf};
  std::mutex mutex;
  absl::Status hung;
  const auto pictures = static_cast<int>(drawn.size() * kFormats.size());
  ParallelFor(pictures, threads, [&](int n) {
    DrawnFigure& one = drawn[n / kFormats.size()];
    const Format format = kFormats[n % kFormats.size()];
    absl::StatusOr<std::string>& picture =
        format == Format::kPng ? one.png : one.pdf;
    if (!one.svg.ok()) {
      picture = one.svg.status();
      return;
    }
    {
      const std::lock_guard lock(mutex);
      if (!hung.ok()) {
        picture = hung;
        return;
      }
    }
    picture = ConvertSvg(*one.svg, format, options);
    if (absl::IsDeadlineExceeded(picture.status())) {
      const std::lock_guard lock(mutex);
      hung = picture.status();
    }
  });
  return drawn;
}

std::vector<std::string> AddPictures(
    const std::vector<DrawnFigure>& drawn,
    std::vector<std::pair<std::string, std::string>>& files) {
  absl::Status failure;
  std::vector<std::string> missing;
  for (const DrawnFigure& one : drawn) {
    for (const auto& [picture, extension] :
         {std::pair{&one.svg, ".svg"}, std::pair{&one.png, ".png"},
          std::pair{&one.pdf, ".pdf"}}) {
      failure.Update(picture->status());
      const std::string name = one.named.name + extension;
      if (picture->ok()) {
        files.emplace_back(name, **picture);
      } else {
        missing.push_back(name);
      }
    }
  }
  if (!failure.ok()) std::cerr << "warning: " << failure.message() << "\n";
  return missing;
}

absl::Status WriteReport(
    const std::string& folder, std::vector<NamedFigure> figures, int threads,
    std::vector<std::pair<std::string, std::string>> files,
    const std::function<std::string(const std::vector<DrawnFigure>&)>& page) {
  const std::vector<DrawnFigure> drawn =
      DrawFigures(std::move(figures), threads);
  const std::vector<std::string> missing = AddPictures(drawn, files);
  files.emplace_back("report.html", page(drawn));
  return WriteFilesTogether(folder, files, missing);
}

bool HasFigure(const std::vector<DrawnFigure>& drawn, std::string_view name) {
  return std::any_of(drawn.begin(), drawn.end(), [&](const DrawnFigure& one) {
    return one.named.name == name;
  });
}

void AddFigure(const std::vector<DrawnFigure>& drawn, std::string_view name,
               HtmlPage& page) {
  for (const DrawnFigure& one : drawn) {
    if (one.named.name != name) continue;
    page.AddFigure(one.named.figure, one.named.caption, one.named.alt);
    return;
  }
}

}  // namespace mle::report
