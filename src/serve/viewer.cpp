// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "viewer.hpp"

#include <netinet/tcp.h>

#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>

#include "backlog.hpp"
#include "link_load.hpp"

namespace nadir::serve {

namespace websocket = beast::websocket;

/// Held by the coroutines that read, write and watch; each ends when the socket is closed.
class Viewer::Conversation : public std::enable_shared_from_this<Viewer::Conversation> {
 public:
  Conversation(Stream stream, std::shared_ptr<Feed::Core> feed, std::optional<std::uint8_t> only)
      : feed_(std::move(feed)),
        only_(only),
        socket_(std::move(stream)),
        wake_(socket_.get_executor()),
        tick_(socket_.get_executor()) {}

  /// The whole conversation.
  asio::awaitable<void> converse(const HttpRequest& request) {
    set_options();
    error_code error;
    co_await socket_.async_accept(request, noting(error));
    if (!error) {
      start(watch());
      const websocket::close_reason reason = co_await listen();
      if (reason) co_await close(reason);
    }
    end();
  }

  /// There are new records.
  void wake() { wake_.cancel(); }

  void dismiss() { start(close({websocket::close_code::going_away, "the server ends"})); }
  void send_away() { start(close({websocket::close_code::service_restart, "this feed ended"})); }

 private:
  // A page hears no WebSocket pings; an idle server repeats itself well within the silence it
  // bears.
  static constexpr auto kBeat = std::chrono::seconds(3);
  static constexpr std::size_t kMessageBytes = 4 << 10;
  static constexpr std::size_t kInboundBytes = 8 << 10;  // per look: a hello and pongs are less
  static constexpr int kUnsentBytes = 4 << 10;           // beyond what is under way
  static constexpr char kCongestionControl[] = "bbr";
  // The grain in which progress is seen; with its frame's header one record of TLS.
  static constexpr std::size_t kChunkBytes = (16 << 10) - 4;
  static constexpr auto kWrongVersion = static_cast<websocket::close_code>(4000);  // RFC 6455 7.4.2

  void set_options() {
    Stream& stream = beast::get_lowest_layer(socket_);
    error_code ignored;
    stream.socket().set_option(tcp::no_delay(true), ignored);
    // What lies in the kernel cannot be superseded nor overtaken any more.
    stream.socket().set_option(tcp::socket::send_buffer_size(feed_->shared.client_bytes), ignored);
    ::setsockopt(stream.socket().native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kUnsentBytes,
                 sizeof kUnsentBytes);
    // A link that loses packets is hardly slower for that; where BBR is not loaded, it is.
    ::setsockopt(stream.socket().native_handle(), IPPROTO_TCP, TCP_CONGESTION, kCongestionControl,
                 sizeof kCongestionControl - 1);
    stream.rate_policy().limit(kInboundBytes);
    socket_.set_option({feed_->shared.timeouts.header, websocket::stream_base::none(), false});
    socket_.read_message_max(kMessageBytes);
    socket_.auto_fragment(false);
    socket_.binary(true);
    socket_.control_callback([this](websocket::frame_type, beast::string_view) {
      heard_ = Clock::now();
      pinged_ = false;
    });
  }

  /// A coroutine beside this one, which keeps the viewer alive.
  void start(asio::awaitable<void> work) {
    spawn(socket_.get_executor(), hold(shared_from_this(), std::move(work)));
  }
  static asio::awaitable<void> hold(std::shared_ptr<Conversation>, asio::awaitable<void> work) {
    co_await std::move(work);
  }

  /// Why to close, none when the viewer did.
  asio::awaitable<websocket::close_reason> listen() {
    error_code error;
    beast::flat_buffer message;
    co_await socket_.async_read(message, noting(error));
    if (error) co_return websocket::close_reason();
    const std::span<const std::uint8_t> bytes(
        static_cast<const std::uint8_t*>(message.data().data()), message.size());
    const auto hello = wire::decode_hello(bytes);
    if (!hello || !socket_.got_binary()) co_return not_understood(bytes);
    const bool resumes =
        hello->feed == feed_->id && hello->last_sequence <= feed_->records.newest();
    backlog_.emplace(feed_->records, resumes ? hello->last_sequence : 0, only_);
    start(send_records());

    message.clear();
    co_await socket_.async_read(message, noting(error));
    if (error) co_return websocket::close_reason();
    co_return websocket::close_reason(websocket::close_code::policy_error,
                                      "a viewer says hello and nothing else");
  }

  static websocket::close_reason not_understood(std::span<const std::uint8_t> bytes) {
    if (bytes.size() < 2 || bytes[0] != wire::kHelloType || bytes[1] == wire::kVersion) {
      return {websocket::close_code::protocol_error, "the first message is not a hello"};
    }
    return {kWrongVersion, "this page speaks protocol " + std::to_string(bytes[1]) +
                               ", the device " + std::to_string(wire::kVersion) +
                               ": reload the page"};
  }

  asio::awaitable<void> send_records() {
    co_await send(wire::encode(wire::Welcome{feed_->id, feed_->records.newest()}));
    while (!gone_) {
      const Clock::time_point begun = Clock::now();
      co_await room();  // what is chosen now cannot be overtaken any more
      if (gone_) break;
      if (const SharedBytes record = backlog_->next(load_.is_thin())) {
        co_await send(*record);
        load_.wrote(begun, Clock::now());
        ++feed_->shared.tally.sent;
      } else {
        error_code woken;
        wake_.expires_after(kBeat);
        co_await wake_.async_wait(noting(woken));
        if (!woken && !gone_) co_await send(backlog_->caught_up());
      }
    }
  }

  /// Waits until nearly all that was written is under way: a write alone succeeds long before, as
  /// the kernel fills what it began whatever TCP_NOTSENT_LOWAT says.
  asio::awaitable<void> room() {
    error_code error;
    progressed_ = Clock::now();
    writing_ = true;
    co_await beast::get_lowest_layer(socket_).socket().async_wait(tcp::socket::wait_write,
                                                                  noting(error));
    writing_ = false;
    if (error) end();
  }

  asio::awaitable<void> send(const wire::Bytes& record) {
    error_code error;
    progressed_ = Clock::now();
    writing_ = true;
    for (std::size_t begin = 0; begin < record.size() && !error; begin += kChunkBytes) {
      const std::size_t size = std::min(kChunkBytes, record.size() - begin);
      const bool last = begin + size == record.size();
      co_await socket_.async_write_some(last, asio::buffer(record.data() + begin, size),
                                        noting(error));
      progressed_ = Clock::now();
    }
    writing_ = false;
    if (error) end();
  }

  asio::awaitable<void> watch() {
    const auto period = std::min({feed_->shared.timeouts.header, feed_->shared.timeouts.idle,
                                  feed_->shared.timeouts.stall}) /
                        4;
    while (!gone_) {
      error_code ignored;
      tick_.expires_after(period);
      co_await tick_.async_wait(noting(ignored));
      if (gone_) break;
      if (!dismissed_) {
        look();
      } else if (Clock::now() - dismissed_at_ > feed_->shared.timeouts.header) {
        ++feed_->shared.tally.timed_out;
        abort();  // the farewell waits for what the viewer does not take
      }
    }
  }

  void look() {
    InboundBudget& budget = beast::get_lowest_layer(socket_).rate_policy();
    if (overdue()) {
      ++feed_->shared.tally.timed_out;
      abort();
    } else if (budget.exceeded()) {
      ++feed_->shared.tally.refused;
      start(close({websocket::close_code::policy_error, "too much is said"}));
    } else if (!pinged_ && Clock::now() - heard_ > feed_->shared.timeouts.idle / 2) {
      pinged_ = true;
      start(ping());
    }
    budget.renew();
  }

  bool overdue() const {
    const auto now = Clock::now();
    if (!backlog_ && now - joined_ > feed_->shared.timeouts.header) return true;
    if (writing_ && now - progressed_ > feed_->shared.timeouts.stall) return true;
    // A pong comes behind what is still under way to a slow viewer.
    return pinged_ &&
           now - heard_ > (writing_ ? feed_->shared.timeouts.stall : feed_->shared.timeouts.idle);
  }

  asio::awaitable<void> ping() {
    error_code ignored;
    co_await socket_.async_ping({}, noting(ignored));
  }

  asio::awaitable<void> close(websocket::close_reason reason) {
    if (std::exchange(dismissed_, true)) co_return;
    dismissed_at_ = Clock::now();
    error_code ignored;
    co_await socket_.async_close(reason, noting(ignored));
    end();
  }

  void end() {
    gone_ = true;
    wake_.cancel();
    tick_.cancel();
    error_code ignored;
    beast::get_lowest_layer(socket_).socket().close(ignored);
  }

  /// Without the kernel waiting for what was sent to arrive.
  void abort() {
    error_code ignored;
    beast::get_lowest_layer(socket_).socket().set_option(tcp::socket::linger(true, 0), ignored);
    end();
  }

  const std::shared_ptr<Feed::Core> feed_;
  const std::optional<std::uint8_t> only_;
  websocket::stream<Stream> socket_;
  asio::steady_timer wake_, tick_;
  std::optional<Backlog> backlog_;  ///< once it said hello
  const Clock::time_point joined_ = Clock::now();
  Clock::time_point heard_ = joined_, progressed_ = joined_, dismissed_at_ = joined_;
  LinkLoad load_{joined_};
  bool writing_ = false, pinged_ = false, dismissed_ = false, gone_ = false;
};

Viewer::Viewer(Stream stream, std::shared_ptr<Feed::Core> feed, std::optional<std::uint8_t> only)
    : conversation_(std::make_shared<Conversation>(std::move(stream), std::move(feed), only)) {}
asio::awaitable<void> Viewer::converse(const HttpRequest& request) {
  return conversation_->converse(request);
}
void Viewer::wake() { conversation_->wake(); }
void Viewer::dismiss() { conversation_->dismiss(); }
void Viewer::send_away() { conversation_->send_away(); }

}  // namespace nadir::serve
