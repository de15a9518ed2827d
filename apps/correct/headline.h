// The result in a line for those who only read one: on the terminal, and at the
// top of the page.

#ifndef APPS_CORRECT_HEADLINE_H_
#define APPS_CORRECT_HEADLINE_H_

#include <string>
#include <vector>

#include "apps/correct/result.h"

namespace mle::correct {

// "Gain of TIC101 ← FC201 fell by 36 %": an element that is corrected.
struct ElementChange {
  int output = 0;
  int input = 0;
  double size = 0.0;  // of its step response, relative
  std::string text;
};

// Changes of the elements of the proposed model, the largest first; none where
// nothing was corrected.
std::vector<ElementChange> ElementChanges(const Result& result);

// The mistake of an operator for which nothing was estimated; null: none.
const Message* Mistake(const Result& result);

// One sentence on the model: the largest change and which others there are,
// that it is unchanged, that this cannot be told, or the configuration error to
// be corrected.
std::string Headline(const Result& result);

// The main reason where nothing is corrected, without what the headline says.
std::string ReasonBesideHeadline(const Result& result);

// Where a gain has turned its sign: what that may be. Otherwise empty.
std::string SignNote(const Result& result);

// One sentence on how to proceed with the controller's model.
std::string Instruction(const Result& result);

// Headline, instruction, the main reason, and where the rest is: at most six
// lines, the first of which says what to do.
std::vector<std::string> ShortVerdict(const Result& result);

}  // namespace mle::correct

#endif  // APPS_CORRECT_HEADLINE_H_
