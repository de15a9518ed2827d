// Messages to addresses with certificates, which are checked.

#include <httplib.h>

#include <cstdlib>
#include <memory>
#include <string>
#include <thread>

#include "absl/strings/str_cat.h"
#include "apps/serve/post.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/mle/base/scratch_folder.h"

namespace mle::serve {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// What OpenSSL takes certificates that are to be believed from.
constexpr char kBelievedVariable[] = "SSL_CERT_FILE";

class SecurePostTest : public ::testing::Test {
 protected:
  ~SecurePostTest() override {
    unsetenv(kBelievedVariable);
    if (server_ != nullptr) server_->stop();
    if (thread_.joinable()) thread_.join();
  }

  // Signed by itself.
  void MakeCertificate(const std::string& host) {
    const std::string command = absl::StrCat(
        "openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=", host,
        " -addext subjectAltName=DNS:", host, " -keyout '", key_, "' -out '",
        certificate_, "' 2>/dev/null");
    ASSERT_EQ(std::system(command.c_str()), 0);
  }
  void Serve() {
    server_ = std::make_unique<httplib::SSLServer>(certificate_.c_str(),
                                                   key_.c_str());
    ASSERT_TRUE(server_->is_valid());
    server_->Post("/alarm", [this](const httplib::Request& request,
                                   httplib::Response& response) {
      ++asked_;
      body_ = request.body;
      response.status = 204;
    });
    port_ = server_->bind_to_any_port("localhost");
    thread_ = std::thread([this] { server_->listen_after_bind(); });
  }
  absl::Status Send() const {
    return PostJson(absl::StrCat("https://localhost:", port_, "/alarm"),
                    R"({"model": "column"})", "id-1");
  }

  const ScratchFolder folder_;
  const std::string key_ = folder_ / "key.pem";
  const std::string certificate_ = folder_ / "certificate.pem";
  std::unique_ptr<httplib::SSLServer> server_;
  std::thread thread_;
  int port_ = 0;
  int asked_ = 0;
  std::string body_;
};

TEST_F(SecurePostTest, ReachesWhoIsBelieved) {
  MakeCertificate("localhost");
  Serve();
  ASSERT_EQ(setenv(kBelievedVariable, certificate_.c_str(), 1), 0);
  const absl::Status status = Send();
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_EQ(asked_, 1);
  EXPECT_EQ(body_, R"({"model": "column"})");
}

TEST_F(SecurePostTest, TellsNothingToWhoIsNotKnown) {
  MakeCertificate("localhost");
  Serve();
  const absl::Status status = Send();
  EXPECT_TRUE(absl::IsUnavailable(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("certificate"));
  // The address may be secret.
  EXPECT_THAT(std::string(status.message()), Not(HasSubstr("localhost")));
  EXPECT_EQ(asked_, 0);
}

TEST_F(SecurePostTest, TellsNothingToWhoHasTheNameOfAnother) {
  MakeCertificate("other.example");
  Serve();
  ASSERT_EQ(setenv(kBelievedVariable, certificate_.c_str(), 1), 0);
  EXPECT_TRUE(absl::IsUnavailable(Send()));
  EXPECT_EQ(asked_, 0);
}

}  // namespace
}  // namespace mle::serve
