#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "apps/common/sha256.h"
#include "apps/report/html.h"
#include "apps/report/text.h"
#include "apps/watch/correction_files.h"
#include "apps/watch/report.h"
#include "apps/watch/site.h"
#include "apps/watch/source.h"
#include "mle/base/absl_view.h"
#include "mle/base/status.h"
#include "mle/data/civil_time.h"
#include "mle/data/time_format.h"
#include "mle/model/json_text.h"
#include "nlohmann/json.hpp"

namespace mle::watch {
namespace {

using serve::PlainResponse;
using serve::Response;

constexpr char kHtml[] = "text/html; charset=utf-8";
constexpr char kJson[] = "application/json";
constexpr char kMetricsType[] = "text/plain; version=0.0.4; charset=utf-8";
constexpr char kApi[] = "/api/v1/";

// Scripts that are not the pages' own do not run, whatever a name may hold.
const std::string& PagePolicy() {
  static const std::string* const kPolicy = [] {
    std::string text =
        "default-src 'none'; style-src 'unsafe-inline'; img-src data:; "
        "form-action 'self'; base-uri 'none'; frame-ancestors 'none'; "
        "script-src 'unsafe-hashes'";
    for (const std::string_view script : report::PageScripts()) {
      absl::StrAppend(
          &text, " 'sha256-",
          absl::Base64Escape(absl::HexStringToBytes(Sha256Of(script))), "'");
    }
    return new std::string(std::move(text));
  }();
  return *kPolicy;
}

void Secure(Response& response) {
  const bool is_page = response.content_type == kHtml;
  const std::pair<std::string, std::string> headers[] = {
      {"Content-Security-Policy",
       is_page ? PagePolicy()
               : "default-src 'none'; frame-ancestors 'none'; sandbox"},
      {"X-Content-Type-Options", "nosniff"},
      {"X-Frame-Options", "DENY"},
      // Not no-referrer, with which forms would come from the origin "null".
      {"Referrer-Policy", "same-origin"},
      {"Cross-Origin-Resource-Policy", "same-origin"},
      {"Cross-Origin-Opener-Policy", "same-origin"},
      {"Cache-Control", "no-cache"}};
  response.headers.insert(response.headers.end(), std::begin(headers),
                          std::end(headers));
}

Response TextResponse(Snapshot::Text text, const char* type) {
  return {.content_type = type, .body = std::move(text)};
}

Response JsonResponse(std::string text, int status = 200) {
  return {.status = status,
          .content_type = kJson,
          .body = std::make_shared<std::string>(std::move(text))};
}

int HttpStatusOf(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kNotFound:
      return 404;
    case absl::StatusCode::kAlreadyExists:
      return 409;
    case absl::StatusCode::kInvalidArgument:
      return 400;
    case absl::StatusCode::kUnauthenticated:
      return 401;
    case absl::StatusCode::kPermissionDenied:
      return 403;
    case absl::StatusCode::kUnavailable:
      return 503;
    default:
      return 500;
  }
}

Response ErrorJson(const absl::Status& status) {
  Response response =
      JsonResponse(FormatJson({{"error", std::string(status.message())}}),
                   HttpStatusOf(status));
  if (response.status == 401) {
    response.headers.emplace_back("WWW-Authenticate", "Bearer");
  }
  return response;
}

std::string ValueOf(const std::map<std::string, std::string>& fields,
                    const std::string& name) {
  const auto found = fields.find(name);
  return found == fields.end() ? "" : found->second;
}

// A day since 1970 from "2024-02-29"; `otherwise` where nothing is given.
absl::StatusOr<int> DayFrom(const serve::Request& request,
                            const std::string& name, int otherwise) {
  const std::string text = ValueOf(request.query, name);
  if (text.empty()) return otherwise;
  const auto civil =
      ReadCivilTime(absl::StrCat(text, "T00:00:00"), FormOf(TimeFormat::kIso));
  if (text.size() != 10 || !civil.has_value()) {
    return InvalidArgument(name, "=", report::CleanText(text),
                           " is not a day as 2024-02-29");
  }
  return static_cast<int>(SecondsSinceEpoch(*civil) / kSecondsOfDay);
}

class Router {
 public:
  Router(Site& site, const serve::Access& access, const serve::Request& request)
      : site_(site),
        access_(access),
        request_(request),
        snapshot_(site.snapshot()) {}

  Response Route() {
    if (!serve::IsHostAllowed(access_, request_.host)) {
      return PlainResponse(
          403, "This name of the server is not known to it; see --host_names.");
    }
    if (snapshot_ == nullptr) {
      Response response = PlainResponse(
          503, "The state is being read for the first time; ask again soon.");
      response.headers.emplace_back("Retry-After", "1");
      return response;
    }
    if (request_.method == "POST") return RoutePost();
    if (request_.method != "GET" && request_.method != "HEAD") {
      Response response = PlainResponse(405, "Only GET, HEAD and POST.");
      response.headers.emplace_back("Allow", "GET, HEAD, POST");
      return response;
    }
    const std::string& path = request_.path;
    if (path == "/" || path == absl::StrCat("/", kOverviewPage)) {
      return TextResponse(snapshot_->overview, kHtml);
    }
    if (path == absl::StrCat("/", kAlarmsPage)) {
      return TextResponse(snapshot_->alarms, kHtml);
    }
    if (path == "/watch.json")
      return TextResponse(snapshot_->watch_json, kJson);
    if (path == "/metrics") {
      return TextResponse(snapshot_->metrics, kMetricsType);
    }
    absl::string_view rest = path;
    if (absl::ConsumePrefix(&rest, kApi)) return RouteApi(rest);
    if (absl::ConsumePrefix(&rest, "/proposals/")) return File(rest);
    if (absl::ConsumePrefix(&rest, "/controller-") &&
        absl::ConsumeSuffix(&rest, ".html")) {
      return Detail(std::string(rest), Site::Detail::kPage);
    }
    return PlainResponse(404, "There is no such page.");
  }

 private:
  const Entry* Find(const std::string& id) const {
    const auto found = snapshot_->by_id.find(id);
    return found == snapshot_->by_id.end()
               ? nullptr
               : snapshot_->entries[found->second].get();
  }

  Response Detail(const std::string& id, Site::Detail detail) {
    const bool is_page = detail == Site::Detail::kPage;
    const Entry* const entry = Find(id);
    if (entry == nullptr) {
      return is_page ? PlainResponse(404, "There is no such controller.")
                     : NoController();
    }
    absl::StatusOr<Snapshot::Text> text = site_.Read(*entry, detail);
    if (!text.ok()) {
      return is_page ? PlainResponse(HttpStatusOf(text.status()),
                                     text.status().message())
                     : ErrorJson(text.status());
    }
    return TextResponse(*std::move(text), is_page ? kHtml : kJson);
  }

  static Response NoController() {
    return ErrorJson(absl::NotFoundError(
        "there is no such controller; /api/v1/controllers lists their ids"));
  }

  Response File(absl::string_view path) const {
    absl::StatusOr<Response> file = FileBelow(
        absl::StrCat(site_.options().folder, "/proposals"), std::string(path));
    return file.ok() ? *std::move(file)
                     : PlainResponse(404, "There is no such file.");
  }

  Response RouteApi(absl::string_view path) {
    if (path == "controllers") return Controllers();
    if (path == "alarms") {
      return JsonResponse(FormatAlarms(
          snapshot_->Reports(), ValueOf(request_.query, "open") == "true"));
    }
    if (absl::ConsumePrefix(&path, "controllers/")) {
      if (absl::ConsumeSuffix(&path, "/history")) {
        return History(std::string(path));
      }
      return Detail(std::string(path), Site::Detail::kJson);
    }
    return ErrorJson(absl::NotFoundError("there is no such path"));
  }

  Response Controllers() const {
    const std::string status = ValueOf(request_.query, "status");
    const std::string search =
        absl::AsciiStrToLower(ValueOf(request_.query, "search"));
    if (status.empty() && search.empty()) {
      return TextResponse(snapshot_->controllers_json, kJson);
    }
    std::vector<Report> reports = snapshot_->Reports();
    std::erase_if(reports, [&](const Report& report) {
      return (!status.empty() && status != NameOf(report.status)) ||
             !absl::StrContains(absl::AsciiStrToLower(report.name), search);
    });
    return JsonResponse(FormatControllers(reports));
  }

  Response History(const std::string& id) {
    const Entry* const entry = Find(id);
    if (entry == nullptr) return NoController();
    const absl::StatusOr<int> from =
        DayFrom(request_, "from", std::numeric_limits<int>::min());
    const absl::StatusOr<int> to =
        DayFrom(request_, "to", std::numeric_limits<int>::max());
    if (!from.ok()) return ErrorJson(from.status());
    if (!to.ok()) return ErrorJson(to.status());
    absl::StatusOr<std::string> text = site_.ReadHistory(*entry, *from, *to);
    return text.ok() ? JsonResponse(*std::move(text))
                     : ErrorJson(text.status());
  }

  Response RoutePost() {
    if (request_.path == kAcknowledgePath) return AcknowledgeForm();
    absl::string_view rest = request_.path;
    if (absl::ConsumePrefix(&rest, "/api/v1/alarms/") &&
        absl::ConsumeSuffix(&rest, "/acknowledgement")) {
      return AcknowledgeJson(std::string(rest));
    }
    return PlainResponse(404, "There is nothing to be changed.");
  }

  // Whether the request may change anything.
  absl::Status Authorize(std::string_view token) const {
    std::string fault = serve::CrossSiteFault(access_, request_);
    if (!fault.empty()) return absl::PermissionDeniedError(fault);
    if (access_.token.empty()) {
      return absl::PermissionDeniedError(
          "This server is read-only: it was started without a token.");
    }
    if (!serve::IsRightToken(access_, std::string(token))) {
      return absl::UnauthenticatedError("The token is not the right one.");
    }
    return absl::OkStatus();
  }

  absl::Status Acknowledge(const std::string& id, const std::string& who,
                           const std::string& note) {
    absl::StatusOr<Acknowledgement> made = MakeAcknowledgement(who, note);
    if (!made.ok()) return made.status();
    return site_.Acknowledge(id, *made);
  }

  Response AcknowledgeJson(const std::string& id) {
    absl::Status status = Authorize(std::string(serve::BearerToken(request_)));
    if (!status.ok()) return ErrorJson(status);
    const auto json = nlohmann::json::parse(request_.body, nullptr, false);
    const auto text = [&](const char* key) {
      return json.is_object() && json.contains(key) && json[key].is_string()
                 ? json[key].get<std::string>()
                 : std::string();
    };
    if (!json.is_object()) {
      return ErrorJson(absl::InvalidArgumentError(
          R"(the body is not JSON as {"who": "Ann", "note": "…"})"));
    }
    status = Acknowledge(id, text("who"), text("note"));
    return status.ok() ? JsonResponse(FormatJson({{"acknowledged", id}}))
                       : ErrorJson(status);
  }

  Response AcknowledgeForm() {
    const auto fields = serve::ParseForm(request_.body);
    if (!fields.has_value() ||
        !absl::StartsWithIgnoreCase(request_.content_type,
                                    "application/x-www-form-urlencoded")) {
      return PlainResponse(400, "The body is not a form.");
    }
    const std::string id = ValueOf(*fields, "alarm");
    absl::Status status = Authorize(ValueOf(*fields, "token"));
    if (status.ok()) {
      status =
          Acknowledge(id, ValueOf(*fields, "who"), ValueOf(*fields, "note"));
    }
    if (!status.ok()) return Refusal(status);
    Response response = PlainResponse(303, "Acknowledged.");
    response.headers.emplace_back("Location", PageOfAlarm(id));
    return response;
  }

  std::string PageOfAlarm(const std::string& id) const {
    for (const auto& entry : snapshot_->entries) {
      for (const Alarm& alarm : entry->watch.alarms) {
        if (alarm.id == id) {
          return absl::StrCat("/", PageName(entry->report));
        }
      }
    }
    return "/";
  }

  Response Refusal(const absl::Status& status) const {
    report::HtmlPage page("The alarm was not acknowledged");
    page.AddWarning(std::string(status.message()));
    page.AddFiles(
        {{"All controllers", kOverviewPage}, {"All alarms", kAlarmsPage}});
    return {.status = HttpStatusOf(status),
            .content_type = kHtml,
            .body = std::make_shared<std::string>(page.Render())};
  }

  Site& site_;
  const serve::Access& access_;
  const serve::Request& request_;
  const std::shared_ptr<const Snapshot> snapshot_;
};

}  // namespace

serve::Response Answer(Site& site, const serve::Access& access,
                       const serve::Request& request) {
  Response response = Router(site, access, request).Route();
  Secure(response);
  return response;
}

}  // namespace mle::watch
