// Names that may have been meant: for messages, and for what is forgiven.
// Internal to this project: not installed.

#ifndef MLE_DATA_NEAREST_NAMES_H_
#define MLE_DATA_NEAREST_NAMES_H_

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace mle {

// In lower case (of ASCII) and without blanks: names that differ in these only
// are taken for each other where that is not ambiguous.
std::string FoldedName(std::string_view name);

// Insertions, deletions, replacements and exchanges of neighbours that make one
// folded name of the other (Damerau and Levenshtein, optimal string alignment).
int NameDistance(std::string_view left, std::string_view right);

// Those of `names`, at most `most`, that are within a third of the length of
// `name`, or contain it or are contained in it; the nearest first.
std::vector<std::string> NearestNames(std::string_view name,
                                      const std::vector<std::string>& names,
                                      std::size_t most = 3);

// As many names as a message shows.
inline constexpr std::size_t kShownNames = 12;

// "'a', 'b' and 3 more": as shown to a user, at most kShownNames.
std::string ListOfNames(const std::vector<std::string>& names);

}  // namespace mle

#endif  // MLE_DATA_NEAREST_NAMES_H_
