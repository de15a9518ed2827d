#include "apps/watch/acknowledgement.h"

#include <pwd.h>
#include <unistd.h>

#include <filesystem>
#include <iostream>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "apps/report/text.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/database/record_sources.h"

namespace mle::watch {
namespace {

constexpr std::size_t kMostName = 200;   // bytes
constexpr std::size_t kMostNote = 1000;  // bytes

std::string CleanPart(const std::string& text) {
  const std::string clean = report::CleanText(text);
  return std::string(absl::StripAsciiWhitespace(clean));
}

// Who has started this program.
std::string UserName() {
  const passwd* const user = getpwuid(getuid());
  return user == nullptr ? "" : user->pw_name;
}

}  // namespace

absl::StatusOr<Acknowledgement> MakeAcknowledgement(const std::string& who,
                                                    const std::string& note) {
  Acknowledgement made = {.who = CleanPart(who),
                          .at = absl::ToUnixSeconds(absl::Now()),
                          .note = CleanPart(note)};
  if (made.who.empty() || made.who.size() > kMostName) {
    return absl::InvalidArgumentError(absl::StrCat(
        "who acknowledges must be given, in at most ", kMostName, " bytes"));
  }
  if (made.note.size() > kMostNote) {
    return absl::InvalidArgumentError(
        absl::StrCat("the note has at most ", kMostNote, " bytes"));
  }
  return made;
}

absl::Status AcknowledgeAlarm(const Request& request) {
  std::error_code error;
  if (!IsDatabase(request.state) &&
      !std::filesystem::exists(request.state, error)) {
    return absl::InvalidArgumentError(
        absl::StrCat("--state: there is no ", request.state));
  }
  MLE_ASSIGN_OR_RETURN(const Acknowledgement made,
                       MakeAcknowledgement(request.acknowledged_by.empty()
                                               ? UserName()
                                               : request.acknowledged_by,
                                           request.note));
  MLE_ASSIGN_OR_RETURN(State state, State::Open(request.state));
  const absl::StatusOr<std::string> id = state.FindAlarm(request.acknowledge);
  if (!id.ok()) return WithPrefix(id.status(), "--acknowledge: ");
  MLE_RETURN_IF_ERROR(state.Acknowledge(*id, made));
  std::cout << "alarm " << *id << " acknowledged by " << made.who << "\n";
  return absl::OkStatus();
}

}  // namespace mle::watch
