#include "apps/report/drawing.h"

#include <array>
#include <iostream>
#include <mutex>

#include "apps/report/svg.h"
#include "mle/base/parallel.h"

namespace mle::report {

std::vector<DrawnFigure> DrawFigures(std::vector<NamedFigure> figures,
                                     int threads,
                                     const ConvertOptions& options) {
  std::vector<DrawnFigure> drawn(figures.size());
  for (std::size_t i = 0; i < figures.size(); ++i) {
    drawn[i].named = std::move(figures[i]);
    const NamedFigure& named = drawn[i].named;
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
