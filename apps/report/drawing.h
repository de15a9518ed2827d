// The figures of a page, drawn in every format at once.
//
//   const std::vector<DrawnFigure> drawn = DrawFigures(MakeFigures(result), 0);
//   AddPictures(drawn, files);  // records.svg, records.png, …
//   AddFigure(drawn, "records", page);

#ifndef APPS_REPORT_DRAWING_H_
#define APPS_REPORT_DRAWING_H_

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/report/figure.h"
#include "apps/report/html.h"

namespace mle::report {

struct NamedFigure {
  std::string name;     // of its files, without extension
  std::string caption;  // says what is shown, in a page
  std::string alt;      // the same to those who cannot see it
  Figure figure;
};

// The bytes of each picture, or why there is none.
struct DrawnFigure {
  NamedFigure named;
  absl::StatusOr<std::string> svg;
  absl::StatusOr<std::string> png;
  absl::StatusOr<std::string> pdf;
};

// In the order given, on `threads` threads (0: one for each processor).
std::vector<DrawnFigure> DrawFigures(std::vector<NamedFigure> figures,
                                     int threads);

// Adds name and content of every picture there is to `files`. The first reason
// why one is missing becomes a warning on standard error: what could not be
// drawn leaves the results as good as they are.
void AddPictures(const std::vector<DrawnFigure>& drawn,
                 std::vector<std::pair<std::string, std::string>>& files);

// The figure of that name; nothing if there is none.
void AddFigure(const std::vector<DrawnFigure>& drawn, std::string_view name,
               HtmlPage& page);

}  // namespace mle::report

#endif  // APPS_REPORT_DRAWING_H_
