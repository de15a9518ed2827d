// Messages to addresses with certificates, which are checked.

#include <microhttpd.h>
#include <netinet/in.h>

#include <cstdlib>
#include <string>

#include "absl/strings/str_cat.h"
#include "apps/serve/post.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/file.h"
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
    if (server_ != nullptr) MHD_stop_daemon(server_);
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
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const std::string key = *ReadFile(key_);
    const std::string certificate = *ReadFile(certificate_);
    server_ = MHD_start_daemon(
        MHD_USE_INTERNAL_POLLING_THREAD | MHD_USE_TLS, 0, nullptr, nullptr,
        &Take, this, MHD_OPTION_SOCK_ADDR, &address, MHD_OPTION_HTTPS_MEM_KEY,
        key.c_str(), MHD_OPTION_HTTPS_MEM_CERT, certificate.c_str(),
        MHD_OPTION_END);
    ASSERT_NE(server_, nullptr);
    port_ = MHD_get_daemon_info(server_, MHD_DAEMON_INFO_BIND_PORT)->port;
  }
  static MHD_Result Take(void* test, MHD_Connection* connection,
                         const char* /*target*/, const char* /*method*/,
                         const char* /*version*/, const char* body,
                         std::size_t* bytes, void** begun) {
    auto& self = *static_cast<SecurePostTest*>(test);
    if (*begun == nullptr) {
      *begun = test;
      return MHD_YES;
    }
    if (*bytes > 0) {
      self.body_.append(body, *bytes);
      *bytes = 0;
      return MHD_YES;
    }
    ++self.asked_;
    MHD_Response* const response =
        MHD_create_response_from_buffer(0, nullptr, MHD_RESPMEM_PERSISTENT);
    const MHD_Result queued = MHD_queue_response(connection, 204, response);
    MHD_destroy_response(response);
    return queued;
  }
  absl::Status Send() const {
    return PostJson(absl::StrCat("https://localhost:", port_, "/alarm"),
                    R"({"model": "column"})", "id-1");
  }

  const ScratchFolder folder_;
  const std::string key_ = folder_ / "key.pem";
  const std::string certificate_ = folder_ / "certificate.pem";
  MHD_Daemon* server_ = nullptr;
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
