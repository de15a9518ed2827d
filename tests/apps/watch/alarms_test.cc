#include "apps/watch/alarms.h"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "apps/serve/server.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "tests/apps/watch/watched_site.h"

namespace mle::watch {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

class AlarmsTest : public ::testing::Test {
 protected:
  AlarmsTest()
      : state_(site_.OpenState()), took_(site_.folder() + "/took.txt") {}

  // A program that keeps its arguments and what it reads, and ends with that
  // exit code.
  std::string Program(int exit_code) const {
    const std::string path = site_.folder() + "/program.sh";
    std::ofstream(path) << "#!/bin/sh\necho \"$@\" >>'" << took_ << "'\ncat >>'"
                        << took_ << "'\nexit " << exit_code << "\n";
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
    return path;
  }
  std::string Took() const {
    std::ostringstream text;
    text << std::ifstream(took_).rdbuf();
    return text.str();
  }
  std::vector<std::string> HandOn(const AlarmTargets& targets) {
    absl::StatusOr<std::vector<std::string>> faults =
        HandOnAlarms(targets, state_);
    EXPECT_TRUE(faults.ok()) << faults.status();
    return *std::move(faults);
  }
  std::size_t PendingOf(Channel channel) {
    return state_.Undelivered(channel)->size();
  }

  WatchedSite site_;
  State state_;
  const std::string took_;
};

TEST_F(AlarmsTest, MailGoesToSendmailOnce) {
  const AlarmTargets targets = {.mail_addresses = {"ann@plant.example", "ops"},
                                .sendmail = Program(0)};
  EXPECT_THAT(HandOn(targets), IsEmpty());
  EXPECT_THAT(HandOn(targets), IsEmpty());
  const std::string took = Took();
  EXPECT_EQ(took.find("-i -- ann@plant.example ops\n"), 0U);
  EXPECT_EQ(took.rfind("-i -- "), 0U);
  const std::size_t head = took.find("\n\n");
  ASSERT_NE(head, std::string::npos);
  EXPECT_THAT(took.substr(0, head),
              HasSubstr("\nTo: ann@plant.example,\n ops\nSubject: =?UTF-8?B?"));
  std::string body;
  ASSERT_TRUE(absl::Base64Unescape(
      absl::StrReplaceAll(took.substr(head), {{"\n", ""}}), &body));
  EXPECT_THAT(body, HasSubstr(kHostileTag));
  EXPECT_THAT(body, HasSubstr(kAlarmId));
}

TEST_F(AlarmsTest, WhatAProgramRefusesIsTriedAgain) {
  const std::vector<std::string> faults = HandOn({.command = Program(7)});
  ASSERT_THAT(faults, SizeIs(1));
  EXPECT_THAT(faults[0], HasSubstr("exit code 7"));
  EXPECT_EQ(PendingOf(Channel::kCommand), 1U);
  EXPECT_THAT(Took(), HasSubstr("\"repeated\": false"));
  EXPECT_THAT(HandOn({.command = Program(0)}), IsEmpty());
  EXPECT_EQ(PendingOf(Channel::kCommand), 0U);
  // It was refused, not lost on the way.
  EXPECT_THAT(Took(), Not(HasSubstr("\"repeated\": true")));
}

TEST_F(AlarmsTest, WhatWasBeingHandedOnAtAKillIsRepeatedAndSaysSo) {
  ASSERT_TRUE(
      state_.SetDelivery(kAlarmId, {.state = Delivery::State::kBeingSent})
          .ok());
  EXPECT_THAT(HandOn({.command = Program(0)}), IsEmpty());
  EXPECT_THAT(Took(), HasSubstr("\"repeated\": true"));
}

TEST_F(AlarmsTest, AnAcknowledgedAlarmIsNotHandedOn) {
  ASSERT_TRUE(state_.Acknowledge(kAlarmId, {.who = "Ann"}).ok());
  EXPECT_THAT(HandOn({.command = Program(0)}), IsEmpty());
  EXPECT_EQ(Took(), "");
}

TEST_F(AlarmsTest, AWebhookGetsTheAlarmOnceItAnswersWell) {
  int status = 500;
  std::vector<serve::Request> asked;
  const auto server = serve::Server::Start({}, [&](const serve::Request& r) {
    asked.push_back(r);
    return serve::PlainResponse(status, "answer");
  });
  ASSERT_TRUE(server.ok());
  const AlarmTargets targets = {
      .webhook =
          absl::StrCat("http://localhost:", (*server)->port(), "/a?b=c")};
  const std::vector<std::string> faults = HandOn(targets);
  ASSERT_THAT(faults, SizeIs(1));
  EXPECT_THAT(faults[0], HasSubstr("status 500"));
  // The address may be secret.
  EXPECT_THAT(faults[0], Not(HasSubstr("localhost")));
  // Redirections are not followed.
  status = 302;
  EXPECT_THAT(HandOn(targets), SizeIs(1));
  EXPECT_EQ(PendingOf(Channel::kWebhook), 1U);
  status = 204;
  EXPECT_THAT(HandOn(targets), IsEmpty());
  EXPECT_THAT(HandOn(targets), IsEmpty());
  ASSERT_THAT(asked, SizeIs(3));
  EXPECT_EQ(asked[2].method, "POST");
  EXPECT_EQ(asked[2].path, "/a");
  EXPECT_EQ(asked[2].content_type, "application/json");
  const nlohmann::json alarm = nlohmann::json::parse(asked[2].body);
  EXPECT_EQ(alarm["id"], kAlarmId);
  EXPECT_EQ(alarm["controller"], "a 1");
  EXPECT_EQ(alarm["repeated"], false);
}

TEST_F(AlarmsTest, NobodyAtTheAddressIsSaidAndKept) {
  int port = 0;
  {
    const auto server = serve::Server::Start({}, nullptr);
    ASSERT_TRUE(server.ok());
    port = (*server)->port();
  }
  const AlarmTargets targets = {.webhook =
                                    absl::StrCat("http://127.0.0.1:", port)};
  EXPECT_THAT(HandOn(targets), SizeIs(1));
  const absl::StatusOr<std::vector<PendingAlarm>> pending =
      state_.Undelivered(Channel::kWebhook);
  ASSERT_TRUE(pending.ok());
  ASSERT_THAT(*pending, SizeIs(1));
  EXPECT_EQ(pending->front().delivery.attempts, 1);
  EXPECT_EQ(pending->front().delivery.state, Delivery::State::kToSend);
  EXPECT_THAT(pending->front().delivery.fault, HasSubstr("not be reached"));
}

TEST_F(AlarmsTest, AChannelIsGivenUpAfterThreeFailuresInARow) {
  absl::StatusOr<Watch> watch = state_.Load("a 1", 1);
  ASSERT_TRUE(watch.ok());
  for (int i = 0; i < 5; ++i) {
    watch->alarms.push_back({.id = absl::StrCat("id", i), .text = "aged"});
  }
  ASSERT_TRUE(state_.Save(*watch).ok());
  EXPECT_THAT(HandOn({.command = Program(1)}), SizeIs(1));
  int tried = 0;
  const absl::StatusOr<std::vector<PendingAlarm>> alarms =
      state_.Undelivered(Channel::kCommand);
  ASSERT_TRUE(alarms.ok());
  for (const PendingAlarm& pending : *alarms) {
    tried += pending.delivery.attempts;
  }
  EXPECT_EQ(tried, 3);
  // The next run begins with the others.
  EXPECT_EQ(alarms->front().delivery.attempts, 0);
}

TEST(CheckTargetsTest, AddressesAreChecked) {
  EXPECT_TRUE(CheckTargets({.mail_addresses = {"a.b+c@d.example", "root"},
                            .webhook = "https://h.example:8443/x?y=z"})
                  .ok());
  for (const char* bad :
       {"", "-oQ/tmp", "a b@c", "a@b\nBcc: d@e", "a@b;c", "<a@b>"}) {
    EXPECT_THAT(std::string(CheckTargets({.mail_addresses = {bad}}).message()),
                HasSubstr("--alarm_mail"))
        << bad;
  }
  for (const char* bad :
       {"ftp://a/", "h.example", "http://", "http://a b/", "http://a:0/",
        "http://a:x/", "http://u:p@a/", "http://a/\r\nX: y"}) {
    EXPECT_THAT(std::string(CheckTargets({.webhook = bad}).message()),
                HasSubstr("--alarm_webhook"))
        << bad;
  }
}

}  // namespace
}  // namespace mle::watch
