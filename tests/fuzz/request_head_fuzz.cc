// Heads of HTTP requests, forms, and where requests come from: what the server
// of mle_watch reads before it knows with whom it speaks.

#include <utility>
#include <vector>

#include "absl/strings/str_split.h"
#include "apps/serve/access.h"
#include "apps/serve/request.h"
#include "tests/fuzz/fuzz.h"

namespace mle {
namespace {

// As a server would find its parts.
serve::Head Split(absl::string_view text) {
  const std::vector<absl::string_view> lines = absl::StrSplit(text, "\r\n");
  const std::vector<absl::string_view> first =
      absl::StrSplit(lines[0], absl::MaxSplits(' ', 2));
  serve::Head head = {.method = first[0],
                      .target = first.size() > 1 ? first[1] : "",
                      .version = first.size() > 2 ? first[2] : "",
                      .headers = {}};
  for (std::size_t i = 1; i < lines.size() && !lines[i].empty(); ++i) {
    const std::pair<absl::string_view, absl::string_view> header =
        absl::StrSplit(lines[i], absl::MaxSplits(':', 1));
    head.headers.push_back(header);
  }
  return head;
}

void CheckHead(std::string_view text) {
  const serve::ParsedHead head =
      serve::ParseHead(Split({text.data(), text.size()}));
  const serve::Request& request = head.request;
  FUZZ_EXPECT(head.status == 200 || head.status >= 400);
  FUZZ_EXPECT((head.status == 200) == head.fault.empty(), head.fault);
  FUZZ_EXPECT(request.body_bytes <= serve::kMostBody);
  FUZZ_EXPECT(request.path.size() <= serve::kMostTarget);
  if (head.status != 200) return;
  FUZZ_EXPECT(!request.method.empty());
  FUZZ_EXPECT(request.path[0] == '/');
  for (const std::string& value :
       {request.host, request.origin, request.authorization, request.path}) {
    FUZZ_EXPECT(value.find_first_of(std::string_view("\r\n\0", 3)) ==
                std::string::npos);
  }
  const serve::Access access = {.host_names = {"watch.plant.example"},
                                .token = "0123456789abcdef"};
  FUZZ_EXPECT(!serve::IsRightToken(access, serve::BearerToken(request)) ||
              request.authorization.find(access.token) != std::string::npos);
  if (serve::IsHostAllowed(access, request.host)) {
    FUZZ_EXPECT(!request.host.empty(), request.host);
  }
  serve::CrossSiteFault(access, request);
}

void CheckForm(std::string_view text) {
  const auto fields = serve::ParseForm({text.data(), text.size()});
  if (!fields.has_value()) return;
  std::size_t bytes = 0;
  for (const auto& [name, value] : *fields) bytes += name.size() + value.size();
  FUZZ_EXPECT(bytes <= text.size());
}

}  // namespace
}  // namespace mle

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data,
                                      std::size_t size) {
  const std::string_view text = mle::fuzz::Bytes(data, size).Rest();
  mle::CheckHead(text);
  mle::CheckForm(text);
  return 0;
}
