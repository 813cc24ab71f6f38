// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Real sockets of this machine, and a pseudo terminal as a serial line.
#include "nadir/sensors/listener.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netdb.h>
#include <netinet/in.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "nadir/sensors/nmea.hpp"

namespace nadir::sensors {
namespace {

/// A file descriptor that closes itself.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) { EXPECT_GE(number, 0); }
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int operator*() const { return number_; }
  void close() {
    if (number_ >= 0) ::close(number_);
    number_ = -1;
  }
  void send(std::string_view text) const {
    EXPECT_EQ(::write(number_, text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }

 private:
  int number_;
};

sockaddr_in local(std::uint32_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  return address;
}

std::uint32_t port_of(const Descriptor& socket) {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  EXPECT_EQ(getsockname(*socket, reinterpret_cast<sockaddr*>(&address), &size), 0);
  return ntohs(address.sin_port);
}

void bind_to(const Descriptor& socket, std::uint32_t port) {
  const int yes = 1;
  setsockopt(*socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  const sockaddr_in address = local(port);
  ASSERT_EQ(bind(*socket, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
}

// Free a moment ago.
std::uint32_t free_udp_port() {
  const Descriptor socket(::socket(AF_INET, SOCK_DGRAM, 0));
  bind_to(socket, 0);
  return port_of(socket);
}

class Listening {
 public:
  explicit Listening(const std::string& input)
      : listener_({parse_input(input)}, {[this](const Heard& one) { add(one); },
                                         [this](const LinkChange& one) { add(one); }}),
        thread_([this](const std::stop_token& stop) { listener_.run(stop); }) {}

  // False when it did not come about in time.
  template <class Condition>
  bool wait_for(Condition condition) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::seconds(20), [&] { return condition(*this); });
  }
  bool hears(std::size_t count) {
    return wait_for([&](const Listening& self) { return self.heard.size() >= count; });
  }
  bool links(std::size_t count) {
    return wait_for([&](const Listening& self) { return self.changes.size() >= count; });
  }
  LinkCounts counts() const { return listener_.counts().front(); }

  std::vector<Heard> heard;
  std::vector<LinkChange> changes;

 private:
  void add(const Heard& one) {
    const std::scoped_lock lock(mutex_);
    heard.push_back(one);
    changed_.notify_all();
  }
  void add(const LinkChange& one) {
    const std::scoped_lock lock(mutex_);
    changes.push_back(one);
    changed_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  Listener listener_;
  std::jthread thread_;
};

const std::string kHeading = nmea_line("GPHDT,90.0,T");
const std::string kUnused = nmea_line("GPGSV,3,1,12");
// SYSTEM_TIME of MAVLink 1.
const std::string kSystemTime(
    "\xfe\x0c\x07\x01\x01\x02\x40\x6e\x63\x5f\xbd\x44\x06\x00\x45\xe2\x01\x00\x3d\xb4", 20);

TEST(Listener, HearsDatagramsAndStampsThemAsTheyArrive) {
  const std::uint32_t port = free_udp_port();
  Listening listening("nmea:udp:127.0.0.1:" + std::to_string(port));
  ASSERT_TRUE(listening.links(1));
  EXPECT_EQ(listening.changes[0].fault, "");
  const Descriptor sender(::socket(AF_INET, SOCK_DGRAM, 0));
  const sockaddr_in to = local(port);
  ASSERT_EQ(connect(*sender, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
  const Time before = monotonic_now();
  sender.send(kHeading + kUnused + "$GPHDT,91.0,T*00\r\n");
  sender.send("$GPHDT,9");                               // a sentence is never in two datagrams
  sender.send(kHeading.substr(0, kHeading.size() - 2));  // one without its end is whole
  sender.send(kHeading);
  ASSERT_TRUE(listening.hears(3));
  const Time after = monotonic_now();
  for (const Heard& heard : listening.heard) {
    EXPECT_NEAR(heard.reading.heading.value(), M_PI / 2, 1e-9);
    EXPECT_GE(heard.time, before);
    EXPECT_LE(heard.time, after);
  }
  EXPECT_EQ(listening.counts().used, 3u);
  EXPECT_EQ(listening.counts().unused, 1u);
  EXPECT_EQ(listening.counts().damaged, 2u);
}

TEST(Listener, CountsDamagedPacketsOfAllDatagrams) {
  const std::uint32_t port = free_udp_port();
  Listening listening("mavlink:udp:127.0.0.1:" + std::to_string(port));
  ASSERT_TRUE(listening.links(1));
  const Descriptor sender(::socket(AF_INET, SOCK_DGRAM, 0));
  const sockaddr_in to = local(port);
  ASSERT_EQ(connect(*sender, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
  std::string damaged = kSystemTime;
  damaged[10] = static_cast<char>(damaged[10] ^ 1);
  sender.send(damaged);
  sender.send(damaged);
  sender.send(kSystemTime);
  ASSERT_TRUE(listening.hears(1));
  EXPECT_EQ(listening.counts().damaged, 2u);
}

TEST(Listener, ConnectsAgainWhenTheOtherSideComesBack) {
  Descriptor server(::socket(AF_INET, SOCK_STREAM, 0));
  bind_to(server, 0);
  const std::uint32_t port = port_of(server);
  Listening listening("nmea:tcp:127.0.0.1:" + std::to_string(port));
  ASSERT_TRUE(listening.links(1));
  EXPECT_NE(listening.changes[0].fault.find("nmea:tcp:127.0.0.1:"), std::string::npos);
  EXPECT_NE(listening.changes[0].fault.find("refused"), std::string::npos);
  ASSERT_EQ(listen(*server, 1), 0);
  {
    const Descriptor client(accept(*server, nullptr, nullptr));
    client.send(kHeading.substr(0, 5));
    client.send(kHeading.substr(5));
    ASSERT_TRUE(listening.hears(1));
    client.send("$GPHDT,9");  // cut off by the end of the connection
  }
  ASSERT_TRUE(listening.links(3));
  EXPECT_EQ(listening.changes[1].fault, "");
  EXPECT_NE(listening.changes[2].fault, "");
  const Descriptor again(accept(*server, nullptr, nullptr));
  again.send(kHeading);
  ASSERT_TRUE(listening.hears(2));
  EXPECT_EQ(listening.counts().damaged, 0u);
}

TEST(Listener, FindsAHostByItsName) {
  addrinfo wanted{}, *found = nullptr;
  wanted.ai_family = AF_INET;
  if (getaddrinfo("localhost", nullptr, &wanted, &found) != 0)
    GTEST_SKIP() << "not run: no host localhost";
  freeaddrinfo(found);
  const Descriptor server(::socket(AF_INET, SOCK_STREAM, 0));
  bind_to(server, 0);
  ASSERT_EQ(listen(*server, 1), 0);
  Listening listening("nmea:tcp:localhost:" + std::to_string(port_of(server)));
  const Descriptor client(accept(*server, nullptr, nullptr));
  client.send(kHeading);
  EXPECT_TRUE(listening.hears(1));
  EXPECT_EQ(listening.counts().bytes, kHeading.size());
}

TEST(Listener, TellsOfANameThatIsNone) {
  Listening listening("nmea:tcp:no-such-host.invalid:1");
  ASSERT_TRUE(listening.links(1));
  EXPECT_NE(listening.changes[0].fault, "");
}

TEST(Listener, ReadsASerialLineAndItsReturn) {
  // A bare root has the node, but nothing behind it.
  const int probe = posix_openpt(O_RDWR | O_NOCTTY);
  if (probe < 0) GTEST_SKIP() << "not run: no pseudo terminals";
  ::close(probe);
  const auto pty = [] {
    auto master = std::make_unique<Descriptor>(posix_openpt(O_RDWR | O_NOCTTY));
    EXPECT_EQ(grantpt(**master), 0);
    EXPECT_EQ(unlockpt(**master), 0);
    return master;
  };
  const std::string link = testing::TempDir() + "nadir-serial-" + std::to_string(getpid());
  const auto plug = [&](const Descriptor& master) {
    unlink(link.c_str());
    ASSERT_EQ(symlink(ptsname(*master), link.c_str()), 0);
  };
  auto master = pty();
  plug(*master);
  Listening listening("mavlink:serial:" + link + ":57600");
  ASSERT_TRUE(listening.links(1));
  EXPECT_EQ(listening.changes[0].fault, "");
  master->send(kSystemTime);
  ASSERT_TRUE(listening.hears(1));
  EXPECT_EQ(listening.heard[0].reading.utc, 1'764'430'000'123'456'000);
  master.reset();  // unplugged
  ASSERT_TRUE(listening.links(2));
  EXPECT_NE(listening.changes[1].fault.find(link), std::string::npos);
  master = pty();
  plug(*master);
  ASSERT_TRUE(listening.links(3));
  EXPECT_EQ(listening.changes[2].fault, "");
  master->send(kSystemTime);
  ASSERT_TRUE(listening.hears(2));
  unlink(link.c_str());
}

TEST(Listener, StopsAtOnceWithNothingHeard) {
  const auto begin = std::chrono::steady_clock::now();
  { Listening listening("nmea:serial:/dev/nowhere:4800"); }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
}

}  // namespace
}  // namespace nadir::sensors
