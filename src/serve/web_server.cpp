// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// All of Beast is in this file: it takes 20 s to compile.
#include "nadir/serve/web_server.hpp"

#include <fcntl.h>
#include <pthread.h>

#include <array>
#include <atomic>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <thread>
#include <utility>

// Asio 1.18 forgets some standard headers, which must come before it.
#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/v6_only.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "backlog.hpp"
#include "inbound_budget.hpp"
#include "nadir/core/check.hpp"
#include "request_rules.hpp"
#include "retained_records.hpp"

namespace nadir::serve {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;
using Clock = std::chrono::steady_clock;
using Stream = beast::basic_stream<tcp, asio::any_io_executor, InboundBudget>;
using HttpRequest = http::request<http::empty_body>;

constexpr std::size_t kHeaderBytes = 8 << 10;
constexpr std::size_t kMessageBytes = 4 << 10;
constexpr std::size_t kInboundBytes = 8
                                      << 10;   // between two looks: a hello and some pongs are less
constexpr std::size_t kChunkBytes = 16 << 10;  // the grain in which a viewer's progress is seen
constexpr auto kWrongVersion =
    static_cast<websocket::close_code>(4000);  // RFC 6455, 7.4.2: private use
constexpr std::chrono::milliseconds kFarewell{300};
constexpr std::chrono::milliseconds kAcceptPause{100};  // without descriptors there is no accepting

auto noting(error_code& error) { return asio::redirect_error(asio::use_awaitable, error); }

Clock::duration from_seconds(double s) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s));
}

/// As it stands in a URL.
std::string local_address(const Stream& stream) {
  error_code error;
  asio::ip::address address = stream.socket().local_endpoint(error).address();
  if (address.is_v4()) return address.to_string();
  if (address.to_v6().is_v4_mapped()) {
    return asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6()).to_string();
  }
  return '[' + asio::ip::address_v6(address.to_v6().to_bytes()).to_string() + ']';
}

std::vector<std::string_view> values(const HttpRequest& request, http::field field) {
  std::vector<std::string_view> all;
  const auto range = request.equal_range(field);
  for (auto it = range.first; it != range.second; ++it) {
    all.emplace_back(it->value().data(), it->value().size());
  }
  return all;
}

Request plain(const HttpRequest& request, bool body) {
  Request plain;
  plain.method = {request.method_string().data(), request.method_string().size()};
  plain.target = {request.target().data(), request.target().size()};
  plain.hosts = values(request, http::field::host);
  plain.origins = values(request, http::field::origin);
  const auto codings = values(request, http::field::accept_encoding);
  if (!codings.empty()) plain.accept_encoding = codings[0];
  plain.upgrade = websocket::is_upgrade(request);
  plain.body = body;
  return plain;
}

/// One page's WebSocket. Three coroutines hold it: one reads, one writes, one watches over time.
struct Viewer {
  explicit Viewer(Stream stream)
      : socket(std::move(stream)), wake(socket.get_executor()), tick(socket.get_executor()) {}

  void end() {
    gone = true;
    wake.cancel();
    tick.cancel();
    error_code ignored;
    beast::get_lowest_layer(socket).socket().close(ignored);
  }

  /// Without waiting for what it was sent to arrive.
  void abort() {
    error_code ignored;
    beast::get_lowest_layer(socket).socket().set_option(tcp::socket::linger(true, 0), ignored);
    end();
  }

  websocket::stream<Stream> socket;
  asio::steady_timer wake, tick;
  std::optional<Backlog> backlog;  ///< once it said hello
  const Clock::time_point joined = Clock::now();
  Clock::time_point heard = joined, progressed = joined;
  bool writing = false, pinged = false, dismissed = false, gone = false;
};

using ViewerPtr = std::shared_ptr<Viewer>;

}  // namespace

void Config::check() const {
  error_code error;
  asio::ip::make_address(address, error);
  const auto require = [](bool good, const char* what) {
    if (!good) throw InputError(what);
  };
  if (error)
    throw InputError("serve.address: '" + address + "' is no IP address; give 0.0.0.0 for all");
  require(max_clients > 0, "serve.max_clients: at least 1 is needed");
  require(client_bytes >= kChunkBytes, "serve.client_bytes: at least 16384 is needed");
  require(retained_bytes >= 1u << 20, "serve.retained_bytes: at least 1048576 is needed");
  require(header_timeout > 0 && idle_timeout > 0 && stall_timeout > 0,
          "serve.header_timeout, idle_timeout, stall_timeout: more than 0 s is needed");
}

class WebServer::Reactor {
 public:
  Reactor(Config config, std::vector<Asset> assets);
  ~Reactor() { stop(); }

  std::uint16_t port() const { return port_; }
  void publish(Lane lane, std::uint64_t key, wire::Bytes record);
  Stats stats() const;
  void stop();

 private:
  using Counter = std::atomic<std::uint64_t>;

  /// One more while it lives.
  struct Counted {
    explicit Counted(Counter& c) : count(c) { ++count; }
    Counted(const Counted&) = delete;
    Counted& operator=(const Counted&) = delete;
    ~Counted() { --count; }
    Counter& count;
  };

  void listen();
  void spawn(asio::awaitable<void> work);
  asio::awaitable<void> accept();
  asio::awaitable<void> answer(Stream stream);
  asio::awaitable<void> reply(Stream& stream, const HttpRequest& request, bool body);
  asio::awaitable<void> refuse(Stream& stream, Refusal refusal);
  asio::awaitable<void> send_asset(Stream& stream, const HttpRequest& request, const Asset& asset);
  template <class Response>
  asio::awaitable<void> send(Stream& stream, Response& response);
  asio::awaitable<void> view(Stream& stream, const HttpRequest& request);
  asio::awaitable<websocket::close_reason> listen_to(ViewerPtr viewer);
  asio::awaitable<void> feed(ViewerPtr viewer);
  asio::awaitable<void> send(Viewer& viewer, const wire::Bytes& record);
  asio::awaitable<void> watch(ViewerPtr viewer);
  bool overdue(const Viewer& viewer) const;
  asio::awaitable<void> ping(ViewerPtr viewer);
  asio::awaitable<void> dismiss(ViewerPtr viewer, websocket::close_reason reason);
  asio::awaitable<void> leave();

  const Config config_;
  const Clock::duration header_timeout_, idle_timeout_, stall_timeout_;
  std::map<std::string, Asset, std::less<>> assets_;
  const std::uint64_t feed_ =
      (std::uint64_t{std::random_device{}()} << 32) | std::random_device{}();
  RetainedRecords records_;
  Counter connections_ = 0, clients_ = 0, sent_ = 0, refused_ = 0, timed_out_ = 0;
  Counter retained_bytes_ = 0, evicted_ = 0;
  std::atomic<bool> stopped_ = false;
  asio::io_context io_{1};
  std::set<ViewerPtr> viewers_;
  tcp::acceptor acceptor_{io_};
  asio::steady_timer farewell_{io_};
  std::uint16_t port_ = 0;
  std::jthread thread_;
};

WebServer::Reactor::Reactor(Config config, std::vector<Asset> assets)
    : config_((config.check(), std::move(config))),
      header_timeout_(from_seconds(config_.header_timeout)),
      idle_timeout_(from_seconds(config_.idle_timeout)),
      stall_timeout_(from_seconds(config_.stall_timeout)),
      records_(config_.retained_bytes) {
  for (Asset& asset : assets) assets_.emplace(asset.path, asset);
  listen();
  spawn(accept());
  thread_ = std::jthread([this] {
    pthread_setname_np(pthread_self(), "serve");
    io_.run();
  });
}

void WebServer::Reactor::listen() {
  const tcp::endpoint endpoint(asio::ip::make_address(config_.address), config_.port);
  error_code error;
  acceptor_.open(endpoint.protocol(), error);
  if (!error) ::fcntl(acceptor_.native_handle(), F_SETFD, FD_CLOEXEC);
  if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error && endpoint.address().is_v6()) {
    acceptor_.set_option(asio::ip::v6_only(false), error);
  }
  if (!error) acceptor_.bind(endpoint, error);
  if (!error) acceptor_.listen(tcp::socket::max_listen_connections, error);
  if (error) {
    throw InputError(
        "cannot listen on " + config_.address + " port " + std::to_string(config_.port) + ": " +
        error.message() +
        "; end the program that holds it or choose another (serve.address, serve.port)");
  }
  port_ = acceptor_.local_endpoint().port();
}

/// A fault in one connection ends that connection only.
void WebServer::Reactor::spawn(asio::awaitable<void> work) {
  asio::co_spawn(io_, std::move(work), [](const std::exception_ptr&) {});
}

void WebServer::Reactor::publish(Lane lane, std::uint64_t key, wire::Bytes record) {
  if (stopped_) return;
  asio::post(io_, [this, lane, key, record = std::move(record)]() mutable {
    records_.put(lane, key, std::move(record));
    retained_bytes_ = records_.bytes();
    evicted_ = records_.evicted();
    for (const ViewerPtr& viewer : viewers_) viewer->wake.cancel();
  });
}

WebServer::Stats WebServer::Reactor::stats() const {
  Stats stats;
  stats.clients = clients_;
  stats.retained_bytes = retained_bytes_;
  stats.evicted = evicted_;
  stats.sent = sent_;
  stats.refused = refused_;
  stats.timed_out = timed_out_;
  return stats;
}

void WebServer::Reactor::stop() {
  if (stopped_.exchange(true)) return;
  asio::post(io_, [this] { spawn(leave()); });
  thread_.join();
}

asio::awaitable<void> WebServer::Reactor::leave() {
  error_code ignored;
  acceptor_.close(ignored);
  for (const ViewerPtr& viewer : viewers_) {
    spawn(dismiss(viewer, {websocket::close_code::going_away, "the server ends"}));
  }
  farewell_.expires_after(kFarewell);
  if (!viewers_.empty()) co_await farewell_.async_wait(noting(ignored));
  io_.stop();
}

// HTTP ------------------------------------------------------------------------------------------

asio::awaitable<void> WebServer::Reactor::accept() {
  while (acceptor_.is_open()) {
    error_code error;
    tcp::socket socket = co_await acceptor_.async_accept(noting(error));
    if (error) {
      asio::steady_timer pause(io_, kAcceptPause);
      co_await pause.async_wait(noting(error));
    } else if (connections_ < 2 * config_.max_clients) {  // viewers and as many short requests
      spawn(answer(Stream(std::move(socket))));
    } else {
      ++refused_;
    }
  }
}

asio::awaitable<void> WebServer::Reactor::answer(Stream stream) {
  const Counted counted(connections_);
  ::fcntl(stream.socket().native_handle(), F_SETFD, FD_CLOEXEC);
  beast::flat_buffer buffer(kHeaderBytes + 1);
  http::request_parser<http::empty_body> parser;
  parser.header_limit(kHeaderBytes);
  error_code error;
  stream.expires_after(header_timeout_);
  co_await http::async_read_header(stream, buffer, parser, noting(error));
  if (error == http::error::header_limit || error == http::error::buffer_overflow) {
    co_await refuse(stream, {431, "the header is too long"});
  } else if (!error) {
    // A body, or anything sent before the answer, as before a WebSocket is open.
    const bool more =
        buffer.size() > 0 || parser.chunked() || parser.content_length().value_or(0) > 0;
    co_await reply(stream, parser.get(), more);
  } else if (error.category() == make_error_code(http::error::bad_line_ending).category() &&
             error != http::error::end_of_stream && error != http::error::partial_message) {
    co_await refuse(stream, {400, "not HTTP/1.1"});
  }
}

asio::awaitable<void> WebServer::Reactor::reply(Stream& stream, const HttpRequest& request,
                                                bool body) {
  const Request question = plain(request, body);
  const std::string_view path = path_of(question.target);
  const auto asset = assets_.find(path);
  if (const auto refusal = refusal_of(question, local_address(stream), config_.names)) {
    co_await refuse(stream, *refusal);
  } else if (question.upgrade && path == kFeedPath) {
    if (viewers_.size() < config_.max_clients) {
      co_await view(stream, request);
    } else {
      co_await refuse(stream, {503, "as many viewers as this device serves are watching"});
    }
  } else if (path == kFeedPath) {
    co_await refuse(stream, {426, "this is a WebSocket"});
  } else if (question.upgrade || asset == assets_.end()) {
    co_await refuse(stream, {404, "not found"});
  } else {
    co_await send_asset(stream, request, asset->second);
  }
}

asio::awaitable<void> WebServer::Reactor::refuse(Stream& stream, Refusal refusal) {
  ++refused_;
  http::response<http::span_body<const char>> response;
  response.result(refusal.status);
  response.set(http::field::content_type, "text/plain; charset=utf-8");
  response.set("Content-Security-Policy", "default-src 'none'");
  if (refusal.status == 405) response.set(http::field::allow, "GET");
  if (refusal.status == 426) response.set(http::field::upgrade, "websocket");
  response.body() = {refusal.reason.data(), refusal.reason.size()};
  co_await send(stream, response);
}

asio::awaitable<void> WebServer::Reactor::send_asset(Stream& stream, const HttpRequest& request,
                                                     const Asset& asset) {
  http::response<http::span_body<const char>> response;
  const auto host = values(request, http::field::host)[0];
  response.set(http::field::content_type, asset.content_type);
  response.set(http::field::content_encoding, "gzip");
  response.set(http::field::cache_control, "no-cache");
  response.set("Content-Security-Policy", content_security_policy(host));
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  response.set("Referrer-Policy", "no-referrer");
  response.body() = {reinterpret_cast<const char*>(asset.gzip.data()), asset.gzip.size()};
  co_await send(stream, response);
}

/// One answer to a connection: nothing can be smuggled in behind the request.
template <class Response>
asio::awaitable<void> WebServer::Reactor::send(Stream& stream, Response& response) {
  response.version(11);
  response.keep_alive(false);
  response.set("X-Content-Type-Options", "nosniff");
  response.prepare_payload();
  error_code error;
  stream.expires_after(stall_timeout_);
  co_await http::async_write(stream, response, noting(error));
  stream.socket().shutdown(tcp::socket::shutdown_send, error);
  // Closing on what was not read would reset the connection and take the answer with it.
  stream.expires_after(header_timeout_);
  std::array<char, 4096> rest;
  for (int reads = 0; reads < 16 && !error; ++reads) {
    co_await stream.async_read_some(asio::buffer(rest), noting(error));
  }
}

// WebSocket -------------------------------------------------------------------------------------

asio::awaitable<void> WebServer::Reactor::view(Stream& stream, const HttpRequest& request) {
  error_code error;
  stream.expires_never();
  stream.socket().set_option(tcp::no_delay(true), error);
  stream.socket().set_option(tcp::socket::send_buffer_size(static_cast<int>(config_.client_bytes)),
                             error);
  stream.rate_policy().limit(kInboundBytes);
  const auto viewer = std::make_shared<Viewer>(std::move(stream));
  viewer->socket.set_option({header_timeout_, websocket::stream_base::none(), false});
  viewer->socket.read_message_max(kMessageBytes);
  viewer->socket.auto_fragment(false);
  viewer->socket.binary(true);
  viewer->socket.control_callback([&v = *viewer](websocket::frame_type, beast::string_view) {
    v.heard = Clock::now();
    v.pinged = false;
  });

  viewers_.insert(viewer);
  clients_ = viewers_.size();
  co_await viewer->socket.async_accept(request, noting(error));
  if (!error) {
    spawn(watch(viewer));
    const websocket::close_reason reason = co_await listen_to(viewer);
    if (reason) co_await dismiss(viewer, reason);
  }
  viewer->end();
  viewers_.erase(viewer);
  clients_ = viewers_.size();
  if (viewers_.empty()) farewell_.cancel();
}

/// Why to close, none when the viewer did.
asio::awaitable<websocket::close_reason> WebServer::Reactor::listen_to(ViewerPtr viewer) {
  error_code error;
  beast::flat_buffer message;
  co_await viewer->socket.async_read(message, noting(error));
  if (error) co_return websocket::close_reason();
  const std::span<const std::uint8_t> bytes(static_cast<const std::uint8_t*>(message.data().data()),
                                            message.size());
  const auto hello = wire::decode_hello(bytes);
  if (!hello || !viewer->socket.got_binary()) {
    const bool other =
        bytes.size() > 1 && bytes[0] == wire::kHelloType && bytes[1] != wire::kVersion;
    if (!other)
      co_return websocket::close_reason(websocket::close_code::protocol_error, "no hello");
    co_return websocket::close_reason(
        kWrongVersion, "this page speaks protocol " + std::to_string(bytes[1]) + ", the device " +
                           std::to_string(wire::kVersion) + ": reload the page");
  }
  const bool resumes = hello->feed == feed_ && hello->last_sequence <= records_.newest();
  viewer->backlog.emplace(records_, resumes ? hello->last_sequence : 0);
  spawn(feed(viewer));

  message.clear();
  co_await viewer->socket.async_read(message, noting(error));
  if (error) co_return websocket::close_reason();
  co_return websocket::close_reason(websocket::close_code::policy_error,
                                    "a viewer says hello and nothing else");
}

asio::awaitable<void> WebServer::Reactor::feed(ViewerPtr viewer) {
  co_await send(*viewer, wire::encode(wire::Welcome{feed_, records_.newest()}));
  while (!viewer->gone) {
    if (const SharedBytes record = viewer->backlog->next()) {
      co_await send(*viewer, *record);
      ++sent_;
    } else {
      error_code ignored;
      viewer->wake.expires_at(Clock::time_point::max());
      co_await viewer->wake.async_wait(noting(ignored));
    }
  }
}

asio::awaitable<void> WebServer::Reactor::send(Viewer& viewer, const wire::Bytes& record) {
  viewer.writing = true;
  viewer.progressed = Clock::now();
  error_code error;
  for (std::size_t begin = 0; begin < record.size() && !error; begin += kChunkBytes) {
    const std::size_t size = std::min(kChunkBytes, record.size() - begin);
    co_await viewer.socket.async_write_some(
        begin + size == record.size(), asio::buffer(record.data() + begin, size), noting(error));
    viewer.progressed = Clock::now();
  }
  viewer.writing = false;
  if (error) viewer.end();
}

asio::awaitable<void> WebServer::Reactor::watch(ViewerPtr viewer) {
  const auto period = std::min({header_timeout_, idle_timeout_, stall_timeout_}) / 4;
  while (!viewer->gone) {
    error_code ignored;
    viewer->tick.expires_after(period);
    co_await viewer->tick.async_wait(noting(ignored));
    if (viewer->gone || viewer->dismissed) co_return;
    InboundBudget& budget = beast::get_lowest_layer(viewer->socket).rate_policy();
    if (overdue(*viewer)) {
      ++timed_out_;
      viewer->abort();
    } else if (budget.exceeded()) {
      ++refused_;
      spawn(dismiss(viewer, {websocket::close_code::too_big, "too much is said"}));
    } else if (!viewer->pinged && Clock::now() - viewer->heard > idle_timeout_ / 2) {
      viewer->pinged = true;
      spawn(ping(viewer));
    }
    budget.renew();
  }
}

bool WebServer::Reactor::overdue(const Viewer& viewer) const {
  const auto now = Clock::now();
  if (!viewer.backlog && now - viewer.joined > header_timeout_) return true;
  if (viewer.writing && now - viewer.progressed > stall_timeout_) return true;
  // A pong comes behind what is still under way to a slow viewer.
  return viewer.pinged && now - viewer.heard > (viewer.writing ? stall_timeout_ : idle_timeout_);
}

asio::awaitable<void> WebServer::Reactor::ping(ViewerPtr viewer) {
  error_code ignored;
  co_await viewer->socket.async_ping({}, noting(ignored));
}

asio::awaitable<void> WebServer::Reactor::dismiss(ViewerPtr viewer,
                                                  websocket::close_reason reason) {
  if (std::exchange(viewer->dismissed, true)) co_return;
  error_code ignored;
  co_await viewer->socket.async_close(reason, noting(ignored));
  viewer->end();
}

// -----------------------------------------------------------------------------------------------

WebServer::WebServer(Config config, std::vector<Asset> assets)
    : reactor_(std::make_unique<Reactor>(std::move(config), std::move(assets))) {}
WebServer::~WebServer() = default;
std::uint16_t WebServer::port() const { return reactor_->port(); }
void WebServer::publish(Lane lane, std::uint64_t key, wire::Bytes record) {
  NADIR_CHECK(record.size() >= wire::kHeaderSize, record.size());
  reactor_->publish(lane, key, std::move(record));
}
WebServer::Stats WebServer::stats() const { return reactor_->stats(); }
void WebServer::stop() { reactor_->stop(); }

}  // namespace nadir::serve
