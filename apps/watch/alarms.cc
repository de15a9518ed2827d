#include "apps/watch/alarms.h"

#include <algorithm>
#include <string_view>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "apps/report/process.h"
#include "apps/report/text.h"
#include "apps/serve/post.h"
#include "apps/watch/source.h"
#include "mle/base/status.h"
#include "mle/model/json_text.h"

namespace mle::watch {
namespace {

constexpr absl::Duration kLongestCommand = absl::Minutes(2);
constexpr int kMostFailures = 3;       // in a row
constexpr std::size_t kMailLine = 76;  // characters

absl::Status RunHandler(const std::string& program,
                        const std::vector<std::string>& arguments,
                        const std::string& text) {
  MLE_ASSIGN_OR_RETURN(const report::ProcessResult run,
                       report::RunProcess(program, arguments, text,
                                          {.time_limit = kLongestCommand}));
  if (run.exit_code == 0) return absl::OkStatus();
  return absl::UnavailableError(absl::StrCat(
      "exit code ", run.exit_code, ": ", absl::StripAsciiWhitespace(run.err)));
}

absl::Status HandOn(const AlarmTargets& targets, const PendingAlarm& pending) {
  switch (pending.delivery.channel) {
    case Channel::kCommand:
      return RunHandler(targets.command, {pending.alarm.id},
                        FormatAlarm(pending));
    case Channel::kMail: {
      std::vector<std::string> arguments = {"-i", "--"};
      arguments.insert(arguments.end(), targets.mail_addresses.begin(),
                       targets.mail_addresses.end());
      return RunHandler(targets.sendmail, arguments,
                        FormatMail(targets, pending));
    }
    case Channel::kWebhook:
      return serve::PostJson(targets.webhook, FormatAlarm(pending),
                             pending.alarm.id);
  }
  return absl::InternalError("no such channel");
}

// The value of the channel's flag; empty: the channel is not used.
std::string TargetOf(const AlarmTargets& targets, Channel channel) {
  switch (channel) {
    case Channel::kCommand:
      return targets.command;
    case Channel::kMail:
      return absl::StrJoin(targets.mail_addresses, ",");
    case Channel::kWebhook:
      return targets.webhook;
  }
  return "";
}

// The flag; a web address may be secret.
std::string OptionOfChannel(const AlarmTargets& targets, Channel channel) {
  const std::string flag =
      absl::StrCat("--alarm_", std::string(NameOf(channel)));
  return channel == Channel::kWebhook
             ? flag
             : absl::StrCat(flag, "=", TargetOf(targets, channel));
}

// A sentence about the first failure; empty without one.
absl::StatusOr<std::string> HandOnThrough(const AlarmTargets& targets,
                                          Channel channel, State& state) {
  MLE_ASSIGN_OR_RETURN(std::vector<PendingAlarm> alarms,
                       state.Undelivered(channel));
  std::string fault;
  int failures = 0;
  for (PendingAlarm& pending : alarms) {
    if (failures == kMostFailures) break;
    Delivery delivery = pending.delivery;
    delivery.state = Delivery::State::kBeingSent;
    ++delivery.attempts;
    MLE_RETURN_IF_ERROR(state.SetDelivery(pending.alarm.id, delivery));
    const absl::Status status = HandOn(targets, pending);
    // Whether what was not answered has arrived is not known.
    const bool unknown = absl::IsDeadlineExceeded(status);
    delivery.state = status.ok() ? Delivery::State::kSent
                     : unknown   ? Delivery::State::kBeingSent
                                 : Delivery::State::kToSend;
    delivery.fault = std::string(status.message());
    MLE_RETURN_IF_ERROR(state.SetDelivery(pending.alarm.id, delivery));
    failures = status.ok() ? 0 : failures + 1;
    if (fault.empty() && !status.ok()) {
      fault = absl::StrCat(OptionOfChannel(targets, channel), ": the alarm of ",
                           pending.controller,
                           " was not taken: ", status.message());
    }
  }
  return fault;
}

bool IsMailAddress(std::string_view text) {
  return !text.empty() && text[0] != '-' &&
         std::all_of(text.begin(), text.end(), [](char c) {
           return absl::ascii_isalnum(static_cast<unsigned char>(c)) ||
                  std::string_view("@._%+-=/").find(c) !=
                      std::string_view::npos;
         });
}

}  // namespace

absl::Status CheckTargets(const AlarmTargets& targets) {
  for (const std::string& address : targets.mail_addresses) {
    if (!IsMailAddress(address)) {
      return InvalidArgument(
          "--alarm_mail: '", report::CleanText(address),
          "' is not an address as engineer@plant.example; several are "
          "separated by commas");
    }
  }
  if (targets.webhook.empty()) return absl::OkStatus();
  const absl::Status status = serve::CheckUrl(targets.webhook);
  return status.ok() ? status
                     : InvalidArgument("--alarm_webhook ", status.message());
}

absl::StatusOr<std::vector<std::string>> HandOnAlarms(
    const AlarmTargets& targets, State& state) {
  std::vector<std::string> faults;
  for (const Channel channel : kChannels) {
    if (TargetOf(targets, channel).empty()) continue;
    MLE_ASSIGN_OR_RETURN(std::string fault,
                         HandOnThrough(targets, channel, state));
    if (!fault.empty()) faults.push_back(std::move(fault));
  }
  return faults;
}

std::string FormatAlarm(const PendingAlarm& pending) {
  return FormatJson(
      {{"id", pending.alarm.id},
       {"controller", pending.controller},
       {"day", NameOfDay(pending.alarm.day)},
       {"text", pending.alarm.text},
       {"repeated", pending.delivery.state == Delivery::State::kBeingSent}});
}

std::string FormatMail(const AlarmTargets& targets,
                       const PendingAlarm& pending) {
  const bool repeated = pending.delivery.state == Delivery::State::kBeingSent;
  const std::string subject = report::CleanText(
      absl::StrCat("Model of ", pending.controller, " has aged"));
  const std::string body = absl::Base64Escape(absl::StrCat(
      report::CleanText(pending.controller), ", ", NameOfDay(pending.alarm.day),
      "\n\n", report::CleanText(pending.alarm.text), "\n\n",
      repeated ? "This message may have been sent before.\n" : "", "Alarm ",
      pending.alarm.id, " of mle_watch.\n"));
  std::string message = absl::StrCat(
      "To: ", absl::StrJoin(targets.mail_addresses, ",\n "),
      "\nSubject: =?UTF-8?B?", absl::Base64Escape(subject), "?=\nDate: ",
      absl::FormatTime(absl::RFC1123_full, absl::Now(), absl::UTCTimeZone()),
      "\nMessage-ID: <", pending.alarm.id,
      "@mle-watch.invalid>\nAuto-Submitted: auto-generated\nMIME-Version: "
      "1.0\nContent-Type: text/plain; charset=utf-8\n"
      "Content-Transfer-Encoding: base64\n\n");
  for (std::size_t at = 0; at < body.size(); at += kMailLine) {
    absl::StrAppend(&message, body.substr(at, kMailLine), "\n");
  }
  return message;
}

}  // namespace mle::watch
