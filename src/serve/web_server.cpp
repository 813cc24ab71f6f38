// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/serve/web_server.hpp"

#include <fcntl.h>
#include <pthread.h>

#include <algorithm>
#include <charconv>
#include <mutex>
#include <random>
#include <thread>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/v6_only.hpp>
#include <boost/asio/post.hpp>

#include "feed_core.hpp"
#include "front.hpp"
#include "nadir/core/check.hpp"
#include "viewer.hpp"

namespace nadir::serve {
namespace {

constexpr std::chrono::milliseconds kFarewell{300};
constexpr std::chrono::milliseconds kAcceptPause{100};  // without descriptors there is no accepting
constexpr std::chrono::seconds kListenPause{1};
constexpr Refusal kTooMany{503, "as many viewers as this device serves are watching"};

using Viewers = std::set<std::shared_ptr<Viewer>>;

/// A viewer among those of its feed while it lives. On a line beside the feed it is there already.
class Seat {
 public:
  Seat(std::shared_ptr<Feed::Core> feed, std::shared_ptr<Viewer> viewer, bool line)
      : feed_(std::move(feed)),
        seat_(feed_->viewers.insert(std::move(viewer)).first),
        of_server_(line ? feed_->shared.tally.lines : feed_->shared.tally.clients) {
    if (!line) of_feed_.emplace(feed_->viewer_count);
  }
  Seat(const Seat&) = delete;
  Seat& operator=(const Seat&) = delete;
  ~Seat() { feed_->viewers.erase(seat_); }

 private:
  const std::shared_ptr<Feed::Core> feed_;
  const std::set<std::shared_ptr<Viewer>>::iterator seat_;
  const Counted of_server_;
  std::optional<Counted> of_feed_;
};

Clock::duration from_seconds(double s) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s));
}

std::string_view target_of(const HttpRequest& request) {
  return {request.target().data(), request.target().size()};
}

/// That kRecordsPath?type=N asks for.
std::optional<std::uint8_t> type_of(std::string_view target) {
  constexpr std::string_view kQuery = "?type=";
  target.remove_prefix(kRecordsPath.size());
  if (!target.starts_with(kQuery)) return std::nullopt;
  target.remove_prefix(kQuery.size());
  const char* const end = target.data() + target.size();
  std::uint8_t type = 0;
  const auto [rest, error] = std::from_chars(target.data(), end, type);
  return error == std::errc() && rest == end ? std::optional(type) : std::nullopt;
}

std::uint64_t random_id() {
  std::random_device random;
  return std::uint64_t{random()} << 32 | (random() | 1u);  // never 0
}

}  // namespace

void Config::check() const {
  error_code error;
  asio::ip::make_address(address, error);
  const auto require = [](bool good, const char* what) {
    if (!good) throw InputError(what);
  };
  if (error) throw InputError("serve.address: '" + address + "' is no IP address, as 0.0.0.0 is");
  if (certificate.empty() != key.empty()) {
    throw InputError(std::string(key.empty() ? "serve.key" : "serve.certificate") +
                     " is missing: serve.certificate and serve.key are needed together; name both "
                     "files or neither");
  }
  require(max_clients > 0, "serve.max_clients: at least 1 is needed");
  require(client_bytes >= 16384 && client_bytes <= 1u << 24,
          "serve.client_bytes: 16384 to 16777216 are possible");
  require(retained_bytes >= 1u << 20, "serve.retained_bytes: at least 1048576 is needed");
  for (const double timeout : {header_timeout, idle_timeout, stall_timeout}) {
    require(timeout >= 0.01 && timeout <= 86400,
            "serve.header_timeout, idle_timeout, stall_timeout: 0.01 to 86400 s are possible");
  }
}

/// Feeds know it by a weak pointer, as they may outlive it.
class WebServer::Reactor : public std::enable_shared_from_this<Reactor> {
 public:
  Reactor(Config config, std::vector<Asset> assets, Handlers handlers);
  ~Reactor() { stop(); }

  /// Once it is held by a shared pointer.
  void start(std::optional<int> listening, Listen when);

  std::uint16_t port() const { return port_; }
  const std::string& listen_fault() const { return listen_fault_; }
  std::shared_ptr<Feed> feed() const;
  std::shared_ptr<Feed> begin_feed();
  std::shared_ptr<Feed> make_feed(std::size_t retained_bytes);
  Stats stats() const;
  void stop();

 private:
  error_code listen();
  void take_over(int listening);
  asio::awaitable<void> listen_in_time();
  asio::awaitable<void> accept();
  asio::awaitable<void> answer(Stream stream);
  bool has_room(const HttpRequest& request) const;
  asio::awaitable<void> view(Stream& stream, const HttpRequest& request);
  asio::awaitable<std::shared_ptr<Feed::Core>> feed_for(Stream& stream, std::string_view target);
  asio::awaitable<void> leave();

  const Config config_;
  Shared shared_;
  Front front_;
  std::atomic<bool> stopped_ = false;
  mutable std::mutex mutex_;
  std::shared_ptr<Feed> feed_;                   ///< current; under the mutex
  std::vector<std::weak_ptr<Feed::Core>> made_;  ///< under the mutex
  asio::io_context io_{1};  // its end destroys the coroutines, which refer to all above
  tcp::acceptor acceptor_{io_};
  asio::steady_timer farewell_{io_};
  std::atomic<std::uint16_t> port_ = 0;
  std::string listen_fault_;
  std::jthread thread_;
};

WebServer::Reactor::Reactor(Config config, std::vector<Asset> assets, Handlers handlers)
    : config_((config.check(), std::move(config))),
      shared_{{from_seconds(config_.header_timeout), from_seconds(config_.idle_timeout),
               from_seconds(config_.stall_timeout)},
              static_cast<int>(config_.client_bytes),
              {}},
      front_(config_, shared_, std::move(assets), std::move(handlers)) {}

void WebServer::Reactor::start(std::optional<int> listening, Listen when) {
  begin_feed();
  if (listening) {
    take_over(*listening);
  } else if (const error_code error = listen()) {
    listen_fault_ = "cannot listen on " + config_.address + " port " +
                    std::to_string(config_.port) + ": " + error.message() +
                    "; end the program that holds it or choose another (serve.address, serve.port)";
    if (when == Listen::at_once) throw InputError(listen_fault_);
  }
  if (port_ != 0) {
    spawn(io_, accept());
  } else {
    spawn(io_, listen_in_time());
  }
  thread_ = std::jthread([this] {
    pthread_setname_np(pthread_self(), "serve");
    io_.run();
  });
}

error_code WebServer::Reactor::listen() {
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
  error_code ignored;
  if (error) {
    acceptor_.close(ignored);
  } else {
    port_ = acceptor_.local_endpoint().port();
  }
  return error;
}

asio::awaitable<void> WebServer::Reactor::listen_in_time() {
  error_code ignored;
  while (!stopped_ && listen()) {
    asio::steady_timer pause(io_, kListenPause);
    co_await pause.async_wait(noting(ignored));
  }
  if (!stopped_) co_await accept();
}

void WebServer::Reactor::take_over(int listening) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  error_code error;
  const bool known = ::getsockname(listening, reinterpret_cast<sockaddr*>(&address), &size) == 0;
  const auto protocol = address.ss_family == AF_INET6 ? tcp::v6() : tcp::v4();
  int listens = 0;
  socklen_t length = sizeof listens;
  ::getsockopt(listening, SOL_SOCKET, SO_ACCEPTCONN, &listens, &length);
  const bool internet =
      listens != 0 && (address.ss_family == AF_INET6 || address.ss_family == AF_INET);
  if (known && internet) acceptor_.assign(protocol, listening, error);
  if (!known || !internet || error) {
    throw InputError(
        "the socket that was handed over does not listen for TCP; correct nadir.socket");
  }
  ::fcntl(listening, F_SETFD, FD_CLOEXEC);
  port_ = acceptor_.local_endpoint().port();
}

std::shared_ptr<Feed> WebServer::Reactor::feed() const {
  const std::scoped_lock lock(mutex_);
  return feed_;
}

std::shared_ptr<Feed> WebServer::Reactor::begin_feed() {
  auto next = make_feed(config_.retained_bytes);
  const std::scoped_lock lock(mutex_);
  const auto before = std::exchange(feed_, next);
  if (before) asio::post(io_, [core = before->core_] { core->end(); });
  return next;
}

std::shared_ptr<Feed> WebServer::Reactor::make_feed(std::size_t retained_bytes) {
  const auto post = [self = weak_from_this()](std::function<void()> work) {
    const auto reactor = self.lock();
    if (reactor && !reactor->stopped_) asio::post(reactor->io_, std::move(work));
  };
  const auto core = std::make_shared<Feed::Core>(random_id(), retained_bytes, shared_, post);
  const std::scoped_lock lock(mutex_);
  std::erase_if(made_, [](const auto& other) { return other.expired(); });
  made_.push_back(core);
  return std::make_shared<Feed>(core);
}

WebServer::Stats WebServer::Reactor::stats() const {
  const Tally& tally = shared_.tally;
  return {tally.clients, tally.retained_bytes, tally.evicted,
          tally.sent,    tally.refused,        tally.timed_out};
}

void WebServer::Reactor::stop() {
  if (stopped_.exchange(true)) return;
  asio::post(io_, [this] { spawn(io_, leave()); });
  if (thread_.joinable()) thread_.join();
  front_.stop();
}

asio::awaitable<void> WebServer::Reactor::leave() {
  error_code ignored;
  acceptor_.close(ignored);
  {
    const std::scoped_lock lock(mutex_);
    for (const auto& made : made_) {
      const auto core = made.lock();
      for (const auto& viewer : core ? core->viewers : Viewers()) viewer->dismiss();
    }
  }
  farewell_.expires_after(kFarewell);
  if (shared_.tally.clients + shared_.tally.lines > 0)
    co_await farewell_.async_wait(noting(ignored));
  io_.stop();
}

asio::awaitable<void> WebServer::Reactor::accept() {
  const std::size_t most = 3 * config_.max_clients;  // viewers, lines and as many short requests
  while (acceptor_.is_open()) {
    error_code error;
    tcp::socket socket = co_await acceptor_.async_accept(noting(error));
    if (error) {
      asio::steady_timer pause(io_, kAcceptPause);
      co_await pause.async_wait(noting(error));
    } else if (shared_.tally.connections < most) {
      spawn(io_, answer(Stream(std::move(socket))));
    } else {
      ++shared_.tally.refused;
    }
  }
}

asio::awaitable<void> WebServer::Reactor::answer(Stream stream) {
  const Counted counted(shared_.tally.connections);
  ::fcntl(stream.socket().native_handle(), F_SETFD, FD_CLOEXEC);
  const std::optional<HttpRequest> for_feed = co_await front_.answer(stream);
  if (!for_feed) co_return;
  if (has_room(*for_feed)) {
    co_await view(stream, *for_feed);
  } else {
    co_await front_.refuse(stream, kTooMany);
  }
}

bool WebServer::Reactor::has_room(const HttpRequest& request) const {
  const Tally& tally = shared_.tally;
  const bool line = target_of(request).starts_with(kRecordsPath);
  return (line ? tally.lines : tally.clients) < config_.max_clients;
}

asio::awaitable<std::shared_ptr<Feed::Core>> WebServer::Reactor::feed_for(Stream& stream,
                                                                          std::string_view target) {
  const std::size_t mark = target.find('?');
  if (mark == std::string_view::npos) co_return feed()->core_;
  std::string query(target.substr(mark + 1));
  const std::shared_ptr<Feed> found = co_await front_.find_feed(stream, std::move(query));
  co_return found ? found->core_ : nullptr;
}

asio::awaitable<void> WebServer::Reactor::view(Stream& stream, const HttpRequest& request) {
  stream.expires_never();
  const std::string_view target = target_of(request);
  std::shared_ptr<Feed::Core> feed;
  std::optional<std::uint8_t> only;
  if (target.starts_with(kRecordsPath)) {
    only = type_of(target);
    if (only) feed = this->feed()->core_;
  } else {
    feed = co_await feed_for(stream, target);
  }
  if (!feed || feed->has_ended) {
    co_await front_.refuse(stream, {404, "there is no such feed"});
    co_return;
  }
  if (!has_room(request)) {  // others came while it was looked for
    co_await front_.refuse(stream, kTooMany);
    co_return;
  }
  {
    const auto viewer = std::make_shared<Viewer>(std::move(stream), feed, only);
    const Seat seat(feed, viewer, only.has_value());
    co_await viewer->converse(request);
  }
  if (shared_.tally.clients + shared_.tally.lines == 0) farewell_.cancel();
}

WebServer::WebServer(Config config, std::vector<Asset> assets, std::optional<int> listening,
                     Listen listen, Handlers handlers)
    : reactor_(
          std::make_shared<Reactor>(std::move(config), std::move(assets), std::move(handlers))) {
  reactor_->start(listening, listen);
}
WebServer::~WebServer() { reactor_->stop(); }
std::uint16_t WebServer::port() const { return reactor_->port(); }
const std::string& WebServer::listen_fault() const { return reactor_->listen_fault(); }
std::shared_ptr<Feed> WebServer::feed() const { return reactor_->feed(); }
std::shared_ptr<Feed> WebServer::begin_feed() { return reactor_->begin_feed(); }
std::shared_ptr<Feed> WebServer::make_feed(std::size_t retained_bytes) const {
  return reactor_->make_feed(retained_bytes);
}
WebServer::Stats WebServer::stats() const { return reactor_->stats(); }
void WebServer::stop() { reactor_->stop(); }

}  // namespace nadir::serve
