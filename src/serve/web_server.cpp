// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/serve/web_server.hpp"

#include <fcntl.h>
#include <pthread.h>

#include <random>
#include <set>
#include <thread>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/v6_only.hpp>
#include <boost/asio/post.hpp>

#include "front.hpp"
#include "nadir/core/check.hpp"
#include "viewer.hpp"

namespace nadir::serve {
namespace {

constexpr std::chrono::milliseconds kFarewell{300};
constexpr std::chrono::milliseconds kAcceptPause{100};  // without descriptors there is no accepting
constexpr std::chrono::seconds kListenPause{1};

using Viewers = std::set<std::shared_ptr<Viewer>>;

/// A viewer among the others while it lives.
class Seat {
 public:
  Seat(Viewers& viewers, std::shared_ptr<Viewer> viewer, Count& count)
      : viewers_(viewers), seat_(viewers.insert(std::move(viewer)).first), count_(count) {
    count_ = viewers_.size();
  }
  Seat(const Seat&) = delete;
  Seat& operator=(const Seat&) = delete;
  ~Seat() {
    viewers_.erase(seat_);
    count_ = viewers_.size();
  }

 private:
  Viewers& viewers_;
  const Viewers::iterator seat_;
  Count& count_;
};

Clock::duration from_seconds(double s) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s));
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
  require(max_clients > 0, "serve.max_clients: at least 1 is needed");
  require(client_bytes >= 16384 && client_bytes <= 1u << 24,
          "serve.client_bytes: 16384 to 16777216 are possible");
  require(retained_bytes >= 1u << 20, "serve.retained_bytes: at least 1048576 is needed");
  for (const double timeout : {header_timeout, idle_timeout, stall_timeout}) {
    require(timeout >= 0.01 && timeout <= 86400,
            "serve.header_timeout, idle_timeout, stall_timeout: 0.01 to 86400 s are possible");
  }
}

class WebServer::Reactor {
 public:
  Reactor(Config config, std::vector<Asset> assets, std::optional<int> listening, Listen when,
          Handler handler);
  ~Reactor() { stop(); }

  std::uint16_t port() const { return port_; }
  const std::string& listen_fault() const { return listen_fault_; }
  void publish(Lane lane, std::uint64_t key, wire::Bytes record);
  Stats stats() const;
  void stop();

 private:
  error_code listen();
  void take_over(int listening);
  asio::awaitable<void> listen_in_time();
  asio::awaitable<void> accept();
  asio::awaitable<void> answer(Stream stream);
  asio::awaitable<void> view(Stream& stream, const HttpRequest& request);
  asio::awaitable<void> leave();

  const Config config_;
  Feed feed_;
  Front front_;
  std::atomic<bool> stopped_ = false;
  Viewers viewers_;
  asio::io_context io_{1};  // its end destroys the coroutines, which refer to all above
  tcp::acceptor acceptor_{io_};
  asio::steady_timer farewell_{io_};
  std::atomic<std::uint16_t> port_ = 0;
  std::string listen_fault_;
  std::jthread thread_;
};

WebServer::Reactor::Reactor(Config config, std::vector<Asset> assets, std::optional<int> listening,
                            Listen when, Handler handler)
    : config_((config.check(), std::move(config))),
      feed_{random_id(),
            RetainedRecords(config_.retained_bytes),
            {from_seconds(config_.header_timeout), from_seconds(config_.idle_timeout),
             from_seconds(config_.stall_timeout)},
            static_cast<int>(config_.client_bytes),
            {}},
      front_(config_, feed_, std::move(assets), std::move(handler)) {
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

void WebServer::Reactor::publish(Lane lane, std::uint64_t key, wire::Bytes record) {
  if (stopped_) return;
  asio::post(io_, [this, lane, key, record = std::move(record)]() mutable {
    feed_.records.put(lane, key, std::move(record));
    feed_.tally.retained_bytes = feed_.records.bytes();
    feed_.tally.evicted = feed_.records.evicted();
    for (const auto& viewer : viewers_) viewer->wake();
  });
}

WebServer::Stats WebServer::Reactor::stats() const {
  const Tally& tally = feed_.tally;
  return {tally.clients, tally.retained_bytes, tally.evicted,
          tally.sent,    tally.refused,        tally.timed_out};
}

void WebServer::Reactor::stop() {
  if (stopped_.exchange(true)) return;
  asio::post(io_, [this] { spawn(io_, leave()); });
  thread_.join();
  front_.stop();
}

asio::awaitable<void> WebServer::Reactor::leave() {
  error_code ignored;
  acceptor_.close(ignored);
  for (const auto& viewer : viewers_) viewer->dismiss();
  farewell_.expires_after(kFarewell);
  if (!viewers_.empty()) co_await farewell_.async_wait(noting(ignored));
  io_.stop();
}

asio::awaitable<void> WebServer::Reactor::accept() {
  const std::size_t most = 2 * config_.max_clients;  // viewers and as many short requests
  while (acceptor_.is_open()) {
    error_code error;
    tcp::socket socket = co_await acceptor_.async_accept(noting(error));
    if (error) {
      asio::steady_timer pause(io_, kAcceptPause);
      co_await pause.async_wait(noting(error));
    } else if (feed_.tally.connections < most) {
      spawn(io_, answer(Stream(std::move(socket))));
    } else {
      ++feed_.tally.refused;
    }
  }
}

asio::awaitable<void> WebServer::Reactor::answer(Stream stream) {
  const Counted counted(feed_.tally.connections);
  ::fcntl(stream.socket().native_handle(), F_SETFD, FD_CLOEXEC);
  const std::optional<HttpRequest> for_feed = co_await front_.answer(stream);
  if (!for_feed) co_return;
  if (viewers_.size() < config_.max_clients) {
    co_await view(stream, *for_feed);
  } else {
    co_await front_.refuse(stream, {503, "as many viewers as this device serves are watching"});
  }
}

asio::awaitable<void> WebServer::Reactor::view(Stream& stream, const HttpRequest& request) {
  stream.expires_never();
  {
    const auto viewer = std::make_shared<Viewer>(std::move(stream), feed_);
    const Seat seat(viewers_, viewer, feed_.tally.clients);
    co_await viewer->converse(request);
  }
  if (viewers_.empty()) farewell_.cancel();
}

WebServer::WebServer(Config config, std::vector<Asset> assets, std::optional<int> listening,
                     Listen listen, Handler handler)
    : reactor_(std::make_unique<Reactor>(std::move(config), std::move(assets), listening, listen,
                                         std::move(handler))) {}
WebServer::~WebServer() = default;
std::uint16_t WebServer::port() const { return reactor_->port(); }
const std::string& WebServer::listen_fault() const { return reactor_->listen_fault(); }
void WebServer::publish(Lane lane, std::uint64_t key, wire::Bytes record) {
  NADIR_CHECK(record.size() >= wire::kHeaderSize, record.size());
  reactor_->publish(lane, key, std::move(record));
}
WebServer::Stats WebServer::stats() const { return reactor_->stats(); }
void WebServer::stop() { reactor_->stop(); }

}  // namespace nadir::serve
