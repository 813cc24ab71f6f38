// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/sensors/listener.hpp"

#include <utility>  // Asio 1.74 uses it without

#include <netinet/tcp.h>
#include <sys/socket.h>

#include <array>
#include <atomic>
#include <boost/asio.hpp>
#include <chrono>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <variant>

#include "nadir/sensors/iio.hpp"
#include "nadir/sensors/mavlink.hpp"
#include "nadir/sensors/nmea.hpp"

namespace nadir::sensors {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using asio::ip::udp;
using boost::system::error_code;

constexpr auto kRetry = std::chrono::seconds(1), kPatience = std::chrono::seconds(5);

struct Counters {
  std::atomic<std::uint64_t> used = 0, unused = 0, damaged = 0, bytes = 0;
};

/// The sentences or packets in an input's bytes.
class Ear {
 public:
  Ear(Protocol protocol, Counters& counters) : protocol_(protocol), counters_(counters) {}

  template <class Take>
  void hear(std::span<const std::uint8_t> bytes, const Take& take) {
    if (protocol_ == Protocol::nmea) {
      hear_nmea(bytes, take);
    } else {
      hear_mavlink(bytes, take);
    }
  }

  /// A line that has no end ends here.
  template <class Take>
  void end(const Take& take) {
    constexpr std::uint8_t kEnd = '\n';
    hear({&kEnd, 1}, take);
    forget();
  }

  /// What came belongs to nothing that follows.
  void forget() {
    lines_ = {};
    packets_ = {};
    damaged_ = 0;
  }

 private:
  template <class Take>
  void hear_nmea(std::span<const std::uint8_t> bytes, const Take& take) {
    lines_.feed({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    while (const auto line = lines_.next()) {
      const NmeaSentence sentence = decode_nmea(*line);
      if (sentence.fault == NmeaFault::none) {
        ++counters_.used;
        take(sentence.reading);
      } else {
        ++(sentence.fault == NmeaFault::unused ? counters_.unused : counters_.damaged);
      }
    }
  }

  template <class Take>
  void hear_mavlink(std::span<const std::uint8_t> bytes, const Take& take) {
    packets_.feed(bytes);
    while (const auto packet = packets_.next()) {
      ++counters_.used;
      take(decode_mavlink(*packet));
    }
    counters_.damaged += packets_.damaged() - std::exchange(damaged_, packets_.damaged());
  }

  Protocol protocol_;
  Counters& counters_;
  NmeaLines lines_;
  MavlinkReader packets_;
  std::uint64_t damaged_ = 0;  ///< of packets_, as far as counted
};

/// One input: opened, read, closed, and opened again a second later.
class Link : public std::enable_shared_from_this<Link> {
 public:
  Link(const std::shared_ptr<asio::io_context>& context, std::size_t index, Input input,
       Listener::Callbacks& callbacks)
      : context_(context),
        index_(index),
        input_(std::move(input)),
        callbacks_(callbacks),
        ear_(input_.protocol, counters_),
        device_("/sys/bus/iio/devices", input_.address),
        timer_(*context) {}

  const Counters& counters() const { return counters_; }

  void open() {
    switch (input_.transport) {
      case Transport::serial:
        return open_serial();
      case Transport::udp:
        return open_udp();
      case Transport::tcp:
        return open_tcp();
      case Transport::device:
        return read_device();
    }
  }

 private:
  void open_serial() {
    auto& port = port_.emplace<asio::serial_port>(*context_);
    error_code error;
    port.open(input_.address, error);
    if (!error) port.set_option(asio::serial_port::baud_rate(input_.rate), error);
    using asio::serial_port_base;
    const auto set = [&](const auto& option) {
      if (!error) port.set_option(option, error);
    };
    set(serial_port_base::character_size(8));
    set(serial_port_base::parity(serial_port_base::parity::none));
    set(serial_port_base::stop_bits(serial_port_base::stop_bits::one));
    set(serial_port_base::flow_control(serial_port_base::flow_control::none));
    if (error) return close(error);
    opened();
    read(port);
  }

  void open_udp() {
    auto& socket = port_.emplace<udp::socket>(*context_);
    error_code error;
    const auto address = asio::ip::make_address(input_.address, error);
    const udp::endpoint endpoint(address, static_cast<std::uint16_t>(input_.rate));
    if (!error) socket.open(endpoint.protocol(), error);
    if (!error) socket.bind(endpoint, error);
    if (error) return close(error);
    opened();
    read(socket);
  }

  // Its file waits for the sensor, some hundredths of a second.
  void read_device() {
    const Time time = monotonic_now();
    const Reading reading = device_.read(time);
    const std::string& fault = device_.fault();
    const bool gives = reading != Reading();  // something, though it may lack the heading
    if (gives) {
      ++counters_.used;
      callbacks_.heard({index_, time, reading});
    }
    if (!lack_ || *lack_ != fault)
      callbacks_.link({index_, time, fault.empty() ? fault : input_.name() + ": " + fault});
    lack_ = fault;
    timer_.expires_after(gives ? std::chrono::milliseconds(1000 / input_.rate) : kRetry);
    timer_.async_wait([this](error_code stopped) {
      if (!stopped) read_device();
    });
  }

  void open_tcp() {
    error_code named;
    const auto address = asio::ip::make_address(input_.address, named);
    const auto port = static_cast<std::uint16_t>(input_.rate);
    if (!named) return connect(std::array{tcp::endpoint(address, port)});
    look_up();
  }

  // A server of names may answer late. Each name has a thread of its own, so that none waits for
  // another, and the end does not wait for it.
  void look_up() {
    give_up_in_time([this] { tell_fault("its name is not found yet"); });
    const auto ask = [context = context_, self = weak_from_this(), host = input_.address,
                      port = std::to_string(input_.rate), attempt = attempt_] {
      asio::io_context own;
      error_code error;
      const auto found = tcp::resolver(own).resolve(host, port, error);
      asio::post(*context, [self, attempt, error, found] {
        const auto link = self.lock();
        if (!link || link->attempt_ != attempt) return;
        ++link->attempt_;
        if (error) return link->close(error);
        link->connect(found);
      });
    };
    try {
      std::thread(ask).detach();
    } catch (const std::system_error&) {
      close(asio::error::no_memory);
    }
  }

  template <class Endpoints>
  void connect(const Endpoints& endpoints) {
    auto& socket = port_.emplace<tcp::socket>(*context_);
    give_up_in_time([this] { close(asio::error::timed_out); });
    asio::async_connect(socket, endpoints,
                        [this, attempt = attempt_](error_code error, const tcp::endpoint&) {
                          if (attempt != attempt_) return;  // too late: its socket is gone
                          if (error) return close(error);
                          ++attempt_;  // it is in time
                          timer_.cancel();
                          notice_lost_peers(std::get<tcp::socket>(port_));
                          opened();
                          read(std::get<tcp::socket>(port_));
                        });
  }

  template <class Act>
  void give_up_in_time(const Act& act) {
    timer_.expires_after(kPatience);
    timer_.async_wait([this, act, attempt = attempt_](error_code stopped) {
      if (!stopped && attempt == attempt_) act();
    });
  }

  // A peer without power says nothing, not even that it is gone.
  static void notice_lost_peers(tcp::socket& socket) {
    const auto set = [&](int level, int name, int value) {
      setsockopt(socket.native_handle(), level, name, &value, sizeof value);
    };
    set(SOL_SOCKET, SO_KEEPALIVE, 1);
    set(IPPROTO_TCP, TCP_KEEPIDLE, 5);
    set(IPPROTO_TCP, TCP_KEEPINTVL, 2);
    set(IPPROTO_TCP, TCP_KEEPCNT, 3);
  }

  void read(udp::socket& socket) {
    socket.async_receive(asio::buffer(buffer_), [this, &socket](error_code error, std::size_t n) {
      if (error) return close(error);
      take(n);
      end();  // a datagram holds whole sentences or packets
      read(socket);
    });
  }

  template <class Stream>
  void read(Stream& stream) {
    stream.async_read_some(asio::buffer(buffer_), [this, &stream](error_code error, std::size_t n) {
      if (error) return close(error);
      take(n);
      read(stream);
    });
  }

  void take(std::size_t size) {
    const Time time = monotonic_now();
    counters_.bytes += size;
    ear_.hear(std::span(buffer_).first(size), [&](const Reading& reading) {
      callbacks_.heard({index_, time, reading});
    });
  }

  void end() {
    const Time time = monotonic_now();
    ear_.end([&](const Reading& reading) { callbacks_.heard({index_, time, reading}); });
  }

  void opened() {
    if (std::exchange(state_, State::open) == State::open) return;
    callbacks_.link({index_, monotonic_now(), {}});
  }

  void close(error_code error) {
    if (error == asio::error::operation_aborted) return;
    port_.emplace<std::monostate>();
    ++attempt_;
    ear_.forget();
    tell_fault(error.message());
    timer_.expires_after(kRetry);
    timer_.async_wait([this](error_code stopped) {
      if (!stopped) open();
    });
  }

  void tell_fault(const std::string& fault) {
    if (std::exchange(state_, State::failed) != State::failed)
      callbacks_.link({index_, monotonic_now(), input_.name() + ": " + fault});
  }

  enum class State { unknown, open, failed };

  const std::shared_ptr<asio::io_context> context_;  ///< also of threads that look up a name
  std::size_t index_;
  Input input_;
  Listener::Callbacks& callbacks_;
  Counters counters_;
  Ear ear_;
  IioDevice device_;
  std::optional<std::string> lack_;  ///< of device_, as it was told
  asio::steady_timer timer_;
  std::variant<std::monostate, asio::serial_port, udp::socket, tcp::socket> port_;
  std::array<std::uint8_t, 4096> buffer_{};
  State state_ = State::unknown;
  std::uint64_t attempt_ = 0;  ///< to connect; what belongs to an earlier one comes too late
};

}  // namespace

struct Listener::State {
  Callbacks callbacks;
  std::shared_ptr<asio::io_context> context = std::make_shared<asio::io_context>(1);
  std::vector<std::shared_ptr<Link>> links;
};

Listener::Listener(const std::vector<Input>& inputs, Callbacks callbacks)
    : state_(std::make_unique<State>()) {
  state_->callbacks = std::move(callbacks);
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    state_->links.push_back(
        std::make_shared<Link>(state_->context, i, inputs[i], state_->callbacks));
  }
}

Listener::~Listener() = default;

void Listener::run(const std::stop_token& stop) {
  const auto idle = asio::make_work_guard(*state_->context);
  const std::stop_callback on_stop(stop, [this] { state_->context->stop(); });
  for (const auto& link : state_->links) link->open();
  state_->context->run();
}

std::vector<LinkCounts> Listener::counts() const {
  std::vector<LinkCounts> counts;
  for (const auto& link : state_->links) {
    const Counters& own = link->counters();
    counts.push_back({own.used, own.unused, own.damaged, own.bytes});
  }
  return counts;
}

}  // namespace nadir::sensors
