// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "front.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

#include <boost/asio/post.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>

#include "certificate.hpp"
#include "http_request.hpp"

namespace nadir::serve {
namespace {

constexpr std::size_t kHeaderBytes = 8 << 10;
constexpr std::size_t kChunkBytes = 64 << 10;  // of a download, read while none is written
constexpr char kHandshakeRecord = 0x16;        // RFC 8446, 5.1; no method begins with it
constexpr std::size_t kMostCalls = 10;
constexpr std::size_t kMostLooks = 8;  // those who command are not kept out by those who look

using Response = http::response<http::span_body<const char>>;

/// What the worker makes of the work.
template <class Result>
asio::awaitable<Result> done_by(Worker& worker, Stream& stream,
                                const std::function<Result()>& work) {
  struct Done {
    explicit Done(const asio::any_io_executor& on) : told(on, Clock::time_point::max()) {}
    asio::steady_timer told;  // cancelled: it is
    Result result{};
  };
  const asio::any_io_executor executor = stream.get_executor();
  const auto done = std::make_shared<Done>(executor);
  worker.post([done, executor, work] {
    done->result = work();
    asio::post(executor, [done] { done->told.cancel(); });
  });
  error_code ignored;
  co_await done->told.async_wait(noting(ignored));
  co_return std::move(done->result);
}

Answer answer_of(const Handler& handler, const Call& call) {
  try {
    return handler(call);
  } catch (const std::exception&) {
    return {500, "application/json", error_json("the device failed to do that")};
  }
}

std::shared_ptr<Feed> feed_of(const FindFeed& find, const std::string& query) {
  try {
    return find(query);
  } catch (const std::exception&) {
    return nullptr;
  }
}

std::ptrdiff_t read_of(const Download& download, std::uint64_t at, std::span<char> into) {
  try {
    return download.read(at, into);
  } catch (const std::exception&) {
    return -1;
  }
}

/// One answer to a connection: nothing can be smuggled in behind the request.
void set_common(Response& response) {
  response.version(11);
  response.keep_alive(false);
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Cross-Origin-Resource-Policy", "same-origin");
}

asio::awaitable<error_code> write(Stream& stream, Response& response, Clock::duration patience) {
  error_code error;
  stream.expires_after(patience);
  co_await http::async_write(stream, response, noting(error));
  co_return error;
}

/// Closing on what was not read would reset the connection and take the answer with it.
asio::awaitable<void> hang_up(Stream& stream, Clock::duration patience) {
  error_code error;
  stream.expires_after(patience);
  co_await stream.end_output();
  std::array<char, 4096> rest;
  for (int reads = 0; reads < 16 && !error; ++reads) {
    co_await stream.plain().async_read_some(asio::buffer(rest), noting(error));
  }
}

bool is_malformed(const error_code& error) {
  return error.category() == make_error_code(http::error::bad_line_ending).category() &&
         error != http::error::end_of_stream && error != http::error::partial_message;
}

/// What to say of a request that could not be read; none to one that was broken off.
std::optional<Refusal> refusal_of_reading(const error_code& error) {
  if (error == http::error::header_limit || error == http::error::buffer_overflow) {
    return Refusal{431, "the header is too long"};
  }
  if (error == http::error::body_limit) return Refusal{413, "the body is too long"};
  if (is_malformed(error)) return Refusal{400, "not HTTP/1.1"};
  return std::nullopt;
}

}  // namespace

struct Front::Reading {
  Reading() {
    parser.header_limit(kHeaderBytes);
    parser.body_limit(kMostBody);
  }
  bool body() const { return parser.chunked() || parser.content_length().value_or(0) > 0; }

  beast::flat_buffer buffer{kHeaderBytes + 1};
  http::request_parser<http::string_body> parser;
};

Front::Front(const Config& config, Shared& shared, std::vector<Asset> assets, Handlers handlers)
    : config_(config), shared_(shared), tls_(tls_context(config)), handlers_(std::move(handlers)) {
  for (Asset& asset : assets) assets_.emplace(asset.path, asset);
}

/// The first byte tells who speaks TLS.
asio::awaitable<error_code> Front::begin(Stream& stream, Reading& reading) {
  error_code error;
  const asio::mutable_buffer room = reading.buffer.prepare(1);
  const std::size_t got = co_await stream.async_read_some(room, noting(error));
  reading.buffer.commit(got);
  const asio::const_buffer begun = reading.buffer.data();
  if (error || *static_cast<const char*>(begun.data()) != kHandshakeRecord) co_return error;
  error = co_await stream.begin_tls(*tls_, begun);
  reading.buffer.clear();
  co_return error;
}

asio::awaitable<std::optional<HttpRequest>> Front::answer(Stream& stream) {
  Reading reading;
  error_code error;
  stream.expires_after(shared_.timeouts.header);
  if (tls_) error = co_await begin(stream, reading);
  if (!error) {
    co_await http::async_read_header(stream, reading.buffer, reading.parser, noting(error));
  }
  if (error) {
    if (const auto refusal = refusal_of_reading(error)) {
      const auto target = reading.parser.get().target();
      const std::string_view path = path_of({target.data(), target.size()});
      co_await refuse(stream, *refusal, handlers_.call && is_call(path));
    }
    co_return std::nullopt;
  }
  const HttpRequest& request = reading.parser.get();
  // A body, or anything sent before the answer, as before a WebSocket is open.
  Request question = plain(request, reading.buffer.size() > 0 || reading.body());
  question.tls = stream.is_tls();
  const std::string_view path = path_of(question.target);
  const bool call = handlers_.call && is_call(path) && !question.upgrade;
  const bool is_feed = path == kFeedPath || path == kRecordsPath;
  const auto asset = assets_.find(path);
  if (const auto refusal = refusal_of(question, local_address(stream), config_.names)) {
    co_await refuse(stream, *refusal, call);
  } else if (question.upgrade && is_feed) {
    co_return reading.parser.release();
  } else if (is_feed) {
    co_await refuse(stream, {426, "this is a WebSocket"});
  } else if (call) {
    co_await answer_call(stream, reading);
  } else if (question.upgrade || asset == assets_.end()) {
    co_await refuse(stream, {404, "not found"});
  } else {
    co_await send_asset(stream, request, asset->second);
  }
  co_return std::nullopt;
}

asio::awaitable<void> Front::answer_call(Stream& stream, Reading& reading) {
  error_code error;
  if (reading.body()) {
    stream.expires_after(2 * shared_.timeouts.header);
    co_await http::async_read(stream, reading.buffer, reading.parser, noting(error));
  }
  std::optional<Refusal> refusal;
  if (error) {
    refusal = refusal_of_reading(error);
    if (!refusal) co_return;
  } else if (reading.buffer.size() > 0) {
    refusal = {400, "more than one request"};
  } else if (calls_ >=
             (reading.parser.get().method() == http::verb::get ? kMostLooks : kMostCalls)) {
    refusal = {503, "the device is busy with other calls; try again"};
  }
  if (refusal) {
    co_await refuse(stream, *refusal, true);
    co_return;
  }
  Answer answer;
  {
    const Counted counted(calls_);
    stream.expires_never();
    const Call call = call_of(stream, reading.parser.get());
    // Named, as GCC 12 destroys some temporaries within a co_await twice.
    const std::function<Answer()> work = [&handler = handlers_.call, call] {
      return answer_of(handler, call);
    };
    answer = co_await done_by(worker_, stream, work);
  }
  if (answer.download && answer.status == 200) {
    co_await send_file(stream, reading.parser.get(), answer);
  } else {
    co_await send(stream, answer);
  }
}

asio::awaitable<std::shared_ptr<Feed>> Front::find_feed(Stream& stream, std::string query) {
  if (!handlers_.feed || calls_ >= kMostLooks) co_return nullptr;
  const Counted counted(calls_);
  const std::function<std::shared_ptr<Feed>()> work = [&find = handlers_.feed, query] {
    return feed_of(find, query);
  };
  co_return co_await done_by(worker_, stream, work);
}

asio::awaitable<void> Front::send(Stream& stream, const Answer& answer) {
  Response response;
  response.result(answer.status);
  response.set(http::field::content_type, answer.content_type);
  response.set(http::field::cache_control, "no-store");
  response.set("Content-Security-Policy", "default-src 'none'");
  if (answer.status == 401) response.set(http::field::www_authenticate, "Bearer");
  response.body() = {answer.text.data(), answer.text.size()};
  set_common(response);
  response.prepare_payload();
  co_await write(stream, response, shared_.timeouts.stall);
  co_await hang_up(stream, shared_.timeouts.header);
}

asio::awaitable<void> Front::send_file(Stream& stream, const HttpRequest& request,
                                       const Answer& answer) {
  const Download& download = *answer.download;
  const DownloadPlaces::Taken place(places_, caller_of(stream), download.size);
  if (!place.granted()) {
    co_await refuse(stream, {503, "as many downloads as this device serves are under way"}, true);
    co_return;
  }
  const bool resumes = is_unchanged(only_value(request, http::field::if_range), download.tag);
  const std::string_view range = resumes ? only_value(request, http::field::range) : "";
  const std::optional<Part> part = part_of(range, download.size);
  const std::string of = '/' + std::to_string(download.size);
  Response response;
  response.set(http::field::accept_ranges, "bytes");
  response.set(http::field::cache_control, "no-cache");
  response.set("Content-Security-Policy", "default-src 'none'; sandbox");
  set_common(response);
  if (!part) {
    response.result(416);
    response.set(http::field::content_range, "bytes *" + of);
    response.prepare_payload();
    co_await write(stream, response, shared_.timeouts.stall);
    co_await hang_up(stream, shared_.timeouts.header);
    co_return;
  }
  if (*part != Part{0, download.size}) {
    response.result(206);
    response.set(http::field::content_range,
                 "bytes " + std::to_string(part->begin) + '-' + std::to_string(part->end - 1) + of);
  }
  response.set(http::field::content_type, answer.content_type);
  response.set(http::field::content_disposition, attachment(download.name));
  if (!download.tag.empty()) response.set(http::field::etag, '"' + download.tag + '"');
  response.content_length(part->end - part->begin);
  const error_code error = co_await write(stream, response, shared_.timeouts.stall);
  if (!error) co_await send_bytes(stream, download, *part);
}

asio::awaitable<void> Front::send_bytes(Stream& stream, const Download& download, Part part) {
  error_code error;
  // What lies in the kernel goes before what the feed has to say on the same link.
  stream.socket().set_option(tcp::socket::send_buffer_size(shared_.client_bytes), error);
  const auto chunk = std::make_shared<std::array<char, kChunkBytes>>();
  for (std::uint64_t at = part.begin; at < part.end;) {
    const auto wanted =
        static_cast<std::size_t>(std::min<std::uint64_t>(kChunkBytes, part.end - at));
    const std::function<std::ptrdiff_t()> work = [chunk, at, wanted, download] {
      return read_of(download, at, std::span(*chunk).first(wanted));
    };
    const std::ptrdiff_t got = co_await done_by(worker_, stream, work);
    if (got <= 0) co_return;  // the length that was promised tells the client
    const std::size_t size = std::min(static_cast<std::size_t>(got), wanted);
    stream.expires_after(shared_.timeouts.stall);
    co_await asio::async_write(stream, asio::buffer(chunk->data(), size), noting(error));
    if (error == beast::error::timeout) ++shared_.tally.timed_out;
    if (error) co_return;
    at += size;
  }
  co_await hang_up(stream, shared_.timeouts.header);
}

asio::awaitable<void> Front::refuse(Stream& stream, Refusal refusal, bool of_call) {
  ++shared_.tally.refused;
  const std::string json = error_json(refusal.reason);
  Response response;
  response.result(refusal.status);
  response.set(http::field::content_type,
               of_call ? "application/json" : "text/plain; charset=utf-8");
  response.set("Content-Security-Policy", "default-src 'none'");
  if (refusal.status == 405)
    response.set(http::field::allow, of_call ? "GET, POST, DELETE" : "GET");
  if (refusal.status == 426) response.set(http::field::upgrade, "websocket");
  const std::string_view text = of_call ? std::string_view(json) : refusal.reason;
  response.body() = {text.data(), text.size()};
  set_common(response);
  response.prepare_payload();
  co_await write(stream, response, shared_.timeouts.stall);
  co_await hang_up(stream, shared_.timeouts.header);
}

asio::awaitable<void> Front::send_asset(Stream& stream, const HttpRequest& request,
                                        const Asset& asset) {
  Response response;
  const auto host = values(request, http::field::host)[0];
  response.set(http::field::content_type, asset.content_type);
  response.set(http::field::content_encoding, "gzip");
  response.set(http::field::cache_control, "no-cache");
  response.set("Content-Security-Policy", content_security_policy(host, stream.is_tls()));
  response.set("Referrer-Policy", "no-referrer");
  response.body() = {reinterpret_cast<const char*>(asset.gzip.data()), asset.gzip.size()};
  set_common(response);
  response.prepare_payload();
  co_await write(stream, response, shared_.timeouts.stall);
  co_await hang_up(stream, shared_.timeouts.header);
}

}  // namespace nadir::serve
