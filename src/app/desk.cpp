// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "desk.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "dive_course.hpp"
#include "folder.hpp"
#include "plain_text.hpp"

namespace nadir::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using serve::Answer;
using serve::Call;

constexpr std::size_t kMostName = 40, kMostNote = 500;  // characters
constexpr std::size_t kLeastSession = 8, kMostSession = 64;
constexpr double kFarthest = 1e7;  // survey units; a mark beyond is a mistake

Answer answered(unsigned status, const json& body) {
  return {status, "application/json", body.dump(-1, ' ', false, json::error_handler_t::replace)};
}
Answer refused(unsigned status, const std::string& why) {
  return answered(status, {{"error", why}});
}
Answer unknown() { return refused(404, "there is no such thing"); }

Answer download(std::optional<serve::Download> found, const char* type) {
  return found ? Answer{200, type, {}, std::move(found)} : unknown();
}

std::vector<std::string_view> steps_of(std::string_view path) {
  path.remove_prefix(std::min(path.size(), serve::kApiPath.size()));
  std::vector<std::string_view> steps;
  for (std::size_t slash = 0; slash != std::string_view::npos;) {
    slash = path.find('/');
    steps.push_back(path.substr(0, slash));
    if (slash != std::string_view::npos) path.remove_prefix(slash + 1);
  }
  return steps;
}

bool is(const std::vector<std::string_view>& steps, const std::vector<std::string_view>& pattern) {
  return std::ranges::equal(steps, pattern, [](std::string_view step, std::string_view like) {
    return like == "*" ? !step.empty() : step == like;
  });
}

std::string value_of(std::string_view query, std::string_view key) {
  const std::string begin = std::string(key) + '=';
  return query.starts_with(begin) ? percent_decoded(query.substr(begin.size())) : "";
}

std::optional<std::uint64_t> number_of(std::string_view text) {
  std::uint64_t number = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && stop == end ? std::optional(number) : std::nullopt;
}

bool is_session(const std::string& text) {
  return text.size() >= kLeastSession && text.size() <= kMostSession &&
         std::ranges::all_of(text, [](unsigned char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                  c == '-' || c == '_';
         });
}

std::string name_of(const Call& call) {
  const std::string name = plain_text(percent_decoded(call.name), kMostName);
  return name.empty() ? "a page without a name" : name;
}

// None when it is no JSON object; nothing is an empty one.
std::optional<json> object_of(const std::string& body) {
  if (body.empty()) return json::object();
  json parsed = json::parse(body, nullptr, false);
  return parsed.is_object() ? std::optional(std::move(parsed)) : std::nullopt;
}

std::optional<double> coordinate(const json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number()) return std::nullopt;
  const double value = *found;
  return std::abs(value) <= kFarthest ? std::optional(value) : std::nullopt;
}

std::optional<Mark> mark_of(const json& object) {
  const auto x = coordinate(object, "x"), y = coordinate(object, "y"), z = coordinate(object, "z");
  if (!x || !y || !z) return std::nullopt;
  Mark mark;
  mark.position = {*x, *y, *z};
  const json image = object.value("image", json()), note = object.value("note", json());
  if (!image.is_null() && !image.is_number_unsigned()) return std::nullopt;
  if (!note.is_null() && !note.is_string()) return std::nullopt;
  if (!image.is_null()) mark.image = image;
  if (!note.is_null()) mark.note = plain_text(note.get<std::string>(), kMostNote);
  return mark;
}

}  // namespace

Desk::Desk(const fs::path& dives, std::string token, std::optional<std::string> url)
    : url_(std::move(url)),
      dives_(dives, live_, record::system_disk()),
      control_(std::move(token),
               [this](const std::string& controller) { live_.set_controller(controller); }) {}

void Desk::serve_by(const serve::WebServer& server, std::size_t retained_bytes) {
  feeds_.make_by([&server, retained_bytes] { return server.make_feed(retained_bytes); });
}

std::shared_ptr<serve::Feed> Desk::recorded(const std::string& query) {
  const auto folder = dives_.recorded(value_of(query, "dive"));
  return folder ? feeds_.find(*folder) : nullptr;
}

Answer Desk::answer(const Call& call) {
  const Steps steps = steps_of(call.path);
  if (call.method == "GET") return look_up(call, steps);
  if (auto refusal = refusal_of(call)) return *std::move(refusal);
  return command(call, steps);
}

Answer Desk::look_up(const Call& call, const Steps& steps) {
  if (is(steps, {"token"})) return show_token(call);
  if (is(steps, {"control"})) return who_controls(200, "");
  if (is(steps, {"marks", "*", "photo"})) return photograph(steps[1]);
  if (is(steps, {"dives"})) return answered(200, dives_.list());
  return steps.front() == "dives" ? look_up_dive(call, steps) : unknown();
}

Answer Desk::look_up_dive(const Call& call, const Steps& steps) {
  constexpr const char* kBytes = "application/octet-stream";
  if (is(steps, {"dives", "*"})) {
    const auto found = dives_.products(std::string(steps[1]), value_of(call.query, "folder"));
    return found ? answered(200, *found) : unknown();
  }
  if (is(steps, {"dives", "*", "archive"})) {
    return download(dives_.archive(std::string(steps[1])), "application/x-tar");
  }
  if (is(steps, {"dives", "*", "images", "*"})) {
    const auto image = number_of(steps[3]);
    return image ? download(dives_.projected(std::string(steps[1]), *image), "image/png")
                 : unknown();
  }
  if (is(steps, {"dives", "*", "files", "*"})) {
    return download(dives_.file(std::string(steps[1]), std::string(steps[3])), kBytes);
  }
  return unknown();
}

// The board's own page shows it to whoever stands before it.
Answer Desk::show_token(const Call& call) const {
  if (!call.local) return refused(403, "the token is shown on the device itself: nadir token");
  return answered(200, {{"token", control_.token()}, {"url", url_ ? json(*url_) : json()}});
}

Answer Desk::photograph(std::string_view mark) const {
  const auto number = number_of(mark);
  const auto name = number ? live_.photograph(*number) : std::nullopt;
  if (!name) return unknown();
  const auto folder = Folder::at(name->parent_path());
  auto photo = folder ? download_of(*folder, name->filename()) : std::nullopt;
  if (!photo) return refused(404, "that image was not projected, or not yet");
  return download(*std::move(photo), "image/png");
}

std::optional<Answer> Desk::refusal_of(const Call& call) {
  switch (control_.admit(call.token, call.caller, Control::Clock::now())) {
    case Control::Admission::wrong:
      return refused(401, "the token of this device is needed: nadir token shows it");
    case Control::Admission::barred:
      return refused(429, "wrong tokens came from there; try again in a minute");
    case Control::Admission::granted:
      break;
  }
  if (!is_session(call.session)) {
    return refused(400, "Nadir-Session is to be 8 to 64 letters and digits");
  }
  return std::nullopt;
}

Answer Desk::command(const Call& call, const Steps& steps) {
  const bool post = call.method == "POST";
  if (post && is(steps, {"control", "*"})) return change_control(call, steps[1]);
  if (!control_.renew(call.session)) {
    const auto other = control_.controller();
    return who_controls(409, other ? *other + " controls" : "nobody controls; take control first");
  }
  if (post && is(steps, {"marks"})) return add_mark(call);
  if (!post && is(steps, {"marks", "*"})) return remove_mark(steps[1]);
  if (!post && is(steps, {"dives", "*"})) return remove_dive(std::string(steps[1]));
  if (post && is(steps, {"dive", "start"})) return give(PageCommand::begin_dive);
  if (post && is(steps, {"dive", "stop"})) return give(PageCommand::end_dive);
  if (post && is(steps, {"dive", "submap"})) return give(PageCommand::new_submap);
  if (post && is(steps, {"shutdown"})) return give(PageCommand::shut_down);
  return unknown();
}

Answer Desk::change_control(const Call& call, std::string_view how) {
  const auto body = object_of(call.body);
  const json force = body ? body->value("force", json(false)) : json();
  if (!force.is_boolean()) return refused(400, "not {\"force\": true or false}");
  if (how == "take") {
    const std::string name = name_of(call);
    control_.take(call.session, name, force);
    // Two may go by one name.
    return control_.renew(call.session)
               ? who_controls(200, "")
               : who_controls(409, control_.controller().value_or(name) + " controls");
  }
  if (how == "renew" && control_.renew(call.session)) return who_controls(200, "");
  if (how == "release" && control_.release(call.session)) return who_controls(200, "");
  if (how != "renew" && how != "release") return unknown();
  return who_controls(409, "this page does not control");
}

Answer Desk::who_controls(unsigned status, const std::string& error) const {
  const auto controller = control_.controller();
  json body{{"controller", controller ? json(*controller) : json()}};
  if (!error.empty()) body["error"] = error;
  return answered(status, body);
}

Answer Desk::add_mark(const Call& call) {
  const auto body = object_of(call.body);
  std::optional<Mark> mark = body ? mark_of(*body) : std::nullopt;
  if (!mark) return refused(400, "not {\"x\", \"y\", \"z\", \"image\", \"note\"} of a place");
  if (!live_.now().is_recording) {
    return refused(409, "no dive is being recorded: a mark would be lost");
  }
  const auto id = live_.add(*std::move(mark));
  if (!id) return refused(409, "the dive ends or its disk is slow: the mark was not taken");
  return answered(202, {{"id", *id}});
}

Answer Desk::remove_mark(std::string_view mark) {
  const auto number = number_of(mark);
  if (!number || !live_.remove(*number)) return refused(404, "the dive has no such mark");
  return answered(202, json::object());
}

Answer Desk::remove_dive(const std::string& dive) {
  if (const auto folder = dives_.recorded(dive)) feeds_.close(*folder);
  switch (dives_.remove(dive)) {
    case Dives::Removal::done:
      return answered(200, json::object());
    case Dives::Removal::in_use:
      return refused(409, "the dive is being recorded or recovered");
    case Dives::Removal::failed:
      return refused(500, "the disk does not let it go");
    case Dives::Removal::unknown:
      break;
  }
  return unknown();
}

Answer Desk::give(PageCommand command) {
  if (commands_.give(command)) return answered(202, json::object());
  return refused(409, "that cannot be done now");
}

serve::Config with_usable_certificate(serve::Config config) {
  const std::string fault = serve::certificate_fault(config);
  if (fault.empty()) return config;
  std::fprintf(stderr, "%s; until then there is no https\n", fault.c_str());
  config.certificate.clear();
  config.key.clear();
  return config;
}

std::optional<std::string> url_for_others(serve::Config config) {
  if (config.port == 0) return std::nullopt;
  std::string& address = config.address;
  const bool everywhere = address == "0.0.0.0" || address == "::";
  if (everywhere && !config.names.empty()) address = config.names.front();
  const bool local =
      address.starts_with("127.") || address == "::1" || address == "0.0.0.0" || address == "::";
  return local ? std::nullopt : std::optional(page_url(config, config.port) + '/');
}

}  // namespace nadir::app
