#include "apps/report/drawing.h"

#include <array>
#include <iostream>

#include "apps/report/gnuplot.h"
#include "mle/base/parallel.h"

namespace mle::report {

std::vector<DrawnFigure> DrawFigures(std::vector<NamedFigure> figures,
                                     int threads) {
  std::vector<DrawnFigure> drawn(figures.size());
  for (std::size_t i = 0; i < figures.size(); ++i) {
    drawn[i].named = std::move(figures[i]);
  }
  constexpr std::array kFormats = {Format::kSvg, Format::kPng, Format::kPdf};
  const auto pictures = static_cast<int>(drawn.size() * kFormats.size());
  ParallelFor(pictures, threads, [&](int n) {
    DrawnFigure& one = drawn[n / kFormats.size()];
    const Format format = kFormats[n % kFormats.size()];
    absl::StatusOr<std::string>& picture = format == Format::kSvg   ? one.svg
                                           : format == Format::kPng ? one.png
                                                                    : one.pdf;
    picture = RenderFigure(one.named.figure, format);
  });
  return drawn;
}

void AddPictures(const std::vector<DrawnFigure>& drawn,
                 std::vector<std::pair<std::string, std::string>>& files) {
  absl::Status failure;
  for (const DrawnFigure& one : drawn) {
    for (const auto& [picture, extension] :
         {std::pair{&one.svg, ".svg"}, std::pair{&one.png, ".png"},
          std::pair{&one.pdf, ".pdf"}}) {
      failure.Update(picture->status());
      if (picture->ok()) {
        files.emplace_back(one.named.name + extension, **picture);
      }
    }
  }
  if (!failure.ok()) std::cerr << "warning: " << failure.message() << "\n";
}

void AddFigure(const std::vector<DrawnFigure>& drawn, std::string_view name,
               HtmlPage& page) {
  for (const DrawnFigure& one : drawn) {
    if (one.named.name != name) continue;
    page.AddFigure(one.named.figure, one.svg, one.named.caption, one.named.alt);
    return;
  }
}

}  // namespace mle::report
