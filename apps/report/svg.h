// An SVG picture made fit to stand inside an HTML page, among others.

#ifndef APPS_REPORT_SVG_H_
#define APPS_REPORT_SVG_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace mle::report {

// `svg`, a whole SVG file, as an element of an HTML page: without the XML
// prolog, comments, title and description; with `prefix` before every id and
// every reference to one, so that pictures on a page do not share ids; as wide
// as there is room, up to 1.4 times its own size; described by `alt` to those
// who cannot see it. InvalidArgument if it is no SVG, has no size, or holds
// anything active (scripts, foreign objects, event handlers).
absl::StatusOr<std::string> EmbedSvg(std::string_view svg,
                                     std::string_view prefix,
                                     std::string_view alt);

}  // namespace mle::report

#endif  // APPS_REPORT_SVG_H_
