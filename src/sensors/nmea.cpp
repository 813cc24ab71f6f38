// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/sensors/nmea.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "angle.hpp"

namespace nadir::sensors {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kKnot = 1852.0 / 3600;
constexpr double kFoot = 0.3048, kFathom = 1.8288;
constexpr double kDeepest = 12000;  // metres; the deepest trench has 11 km

// A field that is no number of its kind makes the whole sentence unusable: a digit lost on the way
// can leave a checksum right by chance, but seldom the grammar.
struct Malformed {};

std::optional<int> hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return std::nullopt;
}

unsigned checksum(std::string_view body) {
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  return sum;
}

std::vector<std::string_view> split(std::string_view text) {
  std::vector<std::string_view> fields;
  while (true) {
    const std::size_t comma = text.find(',');
    fields.push_back(text.substr(0, comma));
    if (comma == text.npos) return fields;
    text.remove_prefix(comma + 1);
  }
}

// The fields after the sentence's name, counted from 1 as the standard does.
class Fields {
 public:
  explicit Fields(std::string_view body) : fields_(split(body)) {}

  std::size_t size() const { return fields_.size() - 1; }
  std::string_view text(std::size_t i) const {
    return i < fields_.size() ? fields_[i] : std::string_view();
  }
  char letter(std::size_t i) const { return text(i).empty() ? '\0' : text(i).front(); }

  std::optional<double> number(std::size_t i) const {
    std::string_view field = text(i);
    if (field.empty()) return std::nullopt;
    if (field.starts_with('+') && !field.starts_with("+-")) field.remove_prefix(1);
    double value = 0;
    const char* end = field.data() + field.size();
    const auto [stop, error] = std::from_chars(field.data(), end, value, std::chars_format::fixed);
    if (error != std::errc() || stop != end || !std::isfinite(value)) throw Malformed();
    return value;
  }

  // Of instruments that give degrees, or integers of which 65536 are a turn.
  std::optional<double> degrees_or_counts(std::size_t i) const {
    const std::optional<double> value = number(i);
    const bool degrees = text(i).find('.') != std::string_view::npos;
    return value && !degrees ? std::optional(*value * 360 / 65536) : value;
  }

  // Absent outside the range.
  std::optional<double> number(std::size_t i, double lowest, double highest) const {
    const std::optional<double> value = number(i);
    return value && *value >= lowest && *value <= highest ? value : std::nullopt;
  }

  std::optional<double> heading(std::size_t i) const;
  std::optional<double> angle(std::size_t i, double largest_deg) const {
    const std::optional<double> degrees = number(i, -largest_deg, largest_deg);
    return degrees ? std::optional(*degrees * kDegree) : std::nullopt;
  }

  // An angle with E or W in the next field, east positive.
  std::optional<double> east(std::size_t i) const {
    const std::optional<double> degrees = number(i, 0, 180);
    if (!degrees || (letter(i + 1) != 'E' && letter(i + 1) != 'W')) return std::nullopt;
    return letter(i + 1) == 'E' ? *degrees * kDegree : -*degrees * kDegree;
  }

 private:
  std::vector<std::string_view> fields_;  ///< the name first
};

std::optional<double> Fields::heading(std::size_t i) const {
  const std::optional<double> degrees = number(i, 0, 360);
  return degrees ? std::optional(as_heading(*degrees * kDegree)) : std::nullopt;
}

// ddmm.mmm with its hemisphere in the next field.
std::optional<double> coordinate(const Fields& fields, std::size_t i, std::string_view hemispheres,
                                 double largest) {
  const std::optional<double> value = fields.number(i);
  const std::size_t hemisphere = hemispheres.find(fields.letter(i + 1));
  if (!value || fields.text(i + 1).empty()) return std::nullopt;
  const double whole = std::floor(*value / 100), minutes = *value - 100 * whole;
  const double degrees = whole + minutes / 60;
  if (*value < 0 || minutes >= 60 || degrees > largest || hemisphere == hemispheres.npos)
    throw Malformed();
  return hemisphere == 0 ? degrees : -degrees;
}

std::optional<Position> position(const Fields& fields, std::size_t i) {
  const std::optional<double> latitude = coordinate(fields, i, "NS", 90);
  const std::optional<double> longitude = coordinate(fields, i + 2, "EW", 180);
  if (!latitude || !longitude) return std::nullopt;
  return Position{*latitude, *longitude, std::nullopt};
}

unsigned two_digits(std::string_view text, std::size_t at) {
  const auto digit = [&](std::size_t i) {
    if (i >= text.size() || text[i] < '0' || text[i] > '9') throw Malformed();
    return static_cast<unsigned>(text[i] - '0');
  };
  return 10 * digit(at) + digit(at + 1);
}

// hhmmss.sss and ddmmyy.
std::optional<Time> utc(const Fields& fields, std::size_t time, std::size_t date) {
  const std::string_view clock = fields.text(time), day = fields.text(date);
  if (clock.empty() || day.empty()) return std::nullopt;
  const unsigned hours = two_digits(clock, 0), minutes = two_digits(clock, 2);
  const double of_minute = fields.number(time).value_or(0) - 10000.0 * hours - 100.0 * minutes;
  // Two digits of a year: receivers are younger than 1980.
  const unsigned year = two_digits(day, 4);
  const std::chrono::year_month_day calendar(
      std::chrono::year(static_cast<int>(year < 80 ? 2000 + year : 1900 + year)),
      std::chrono::month(two_digits(day, 2)), std::chrono::day(two_digits(day, 0)));
  if (!calendar.ok() || day.size() != 6 || hours > 23 || minutes > 59 || of_minute < 0 ||
      of_minute >= 61)
    throw Malformed();
  const std::chrono::nanoseconds midnight = std::chrono::sys_days(calendar).time_since_epoch();
  return midnight.count() + from_seconds(3600.0 * hours + 60.0 * minutes + of_minute);
}

std::optional<double> altitude(std::optional<double> metres) {
  // Sounders that have lost the ground send 0.
  return metres && *metres > 0 && *metres < kDeepest ? metres : std::nullopt;
}

// Deviation and variation: east is added to the compass's own reading.
void hdg(const Fields& fields, Reading& reading) {
  reading.variation = fields.east(4);
  if (const auto sensor = fields.heading(1))
    reading.magnetic_heading = as_heading(*sensor + fields.east(2).value_or(0));
}

void hdm(const Fields& fields, Reading& reading) {
  if (fields.letter(2) == 'M') reading.magnetic_heading = fields.heading(1);
}

void hdt(const Fields& fields, Reading& reading) {
  if (fields.letter(2) == 'T') reading.heading = fields.heading(1);
}

// Degrees per minute.
void rot(const Fields& fields, Reading& reading) {
  constexpr double kFastest = 7200;  // degrees per minute: a turn in 3 s
  const std::optional<double> rate = fields.number(1, -kFastest, kFastest);
  if (rate && fields.letter(2) == 'A') reading.turn_rate = *rate * kDegree / 60;
}

void dpt(const Fields& fields, Reading& reading) { reading.altitude = altitude(fields.number(1)); }

// The same in feet, metres and fathoms; older sounders fill in one of them.
void dbt(const Fields& fields, Reading& reading) {
  const auto in = [&](std::size_t i, double unit) {
    const std::optional<double> value = fields.number(i);
    return value ? std::optional(*value * unit) : std::nullopt;
  };
  const std::optional<double> feet = in(1, kFoot), metres = in(3, 1), fathoms = in(5, kFathom);
  reading.altitude = altitude(metres ? metres : feet ? feet : fathoms);
}

// The mode of later editions: A autonomous, D differential, E estimated, R F P precise; N not
// valid, M typed in, S simulated.
bool is_valid_mode(std::string_view mode) { return mode.empty() || mode.find_first_of("NMS") != 0; }

void vtg(const Fields& fields, Reading& reading) {
  if (!is_valid_mode(fields.text(9))) return;
  reading.course = fields.heading(1);
  const std::optional<double> knots = fields.number(5, 0, 1000), km_h = fields.number(7, 0, 2000);
  if (knots) {
    reading.speed = *knots * kKnot;
  } else if (km_h) {
    reading.speed = *km_h / 3.6;
  }
}

// One sigma: the dilution times the error of one range, 4 m (GPS SPS performance standard, 2020).
std::optional<double> sigma_of_fix(char quality, std::optional<double> dilution) {
  constexpr double kFixed = 0.02, kFloat = 0.5, kRange = 4, kDifferentialRange = 1;
  if (quality == '4') return kFixed;
  if (quality == '5') return kFloat;
  if (!dilution || quality == '6') return std::nullopt;  // dead reckoning: nobody knows
  return *dilution * (quality == '2' || quality == '3' ? kDifferentialRange : kRange);
}

void gga(const Fields& fields, Reading& reading) {
  const char quality = fields.letter(6);
  if (quality < '1' || quality > '6') return;  // 0 none, 7 typed in, 8 simulated
  reading.position = position(fields, 2);
  if (reading.position) reading.position->sigma = sigma_of_fix(quality, fields.number(8, 0.01, 99));
}

void rmc(const Fields& fields, Reading& reading) {
  if (fields.letter(2) != 'A' || !is_valid_mode(fields.text(12))) return;
  reading.utc = utc(fields, 1, 9);
  reading.position = position(fields, 3);
  if (const auto knots = fields.number(7, 0, 1000)) reading.speed = *knots * kKnot;
  reading.course = fields.heading(8);
  reading.variation = fields.east(10);
}

// Groups of a kind, a value, its unit and the transducer's name.
void xdr(const Fields& fields, Reading& reading) {
  const auto is = [](std::string_view name, std::initializer_list<std::string_view> names) {
    return std::ranges::any_of(names, [&](std::string_view one) { return name.starts_with(one); });
  };
  for (std::size_t i = 1; i + 3 <= fields.size(); i += 4) {
    std::string name(fields.text(i + 3));
    std::ranges::transform(name, name.begin(), [](char c) {
      return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    });
    const char kind = fields.letter(i), unit = fields.letter(i + 2);
    if (kind == 'A' && unit == 'D' && is(name, {"ROLL", "HEEL"}))
      reading.roll = fields.angle(i + 1, 180);
    if (kind == 'A' && unit == 'D' && is(name, {"PITCH", "PTCH", "TRIM"}))
      reading.pitch = fields.angle(i + 1, 90);
    if (kind == 'D' && unit == 'M' && is(name, {"DEPTH"}))
      reading.depth = fields.number(i + 1, -kDeepest, kDeepest);
  }
}

// Heading, roll (port side up positive), pitch (bow up positive), as receivers with inertial units
// send them. Others of the same name (SAT, POS, ATT of Ashtech) have no T there.
void pashr(const Fields& fields, Reading& reading) {
  if (fields.text(3) != "T") return;
  reading.heading = fields.heading(2);
  reading.roll = fields.angle(4, 180);
  reading.pitch = fields.angle(5, 90);
}

// True heading, pitch and roll of a True North compass, each with a state of its own: N normal, M
// and O warn, all else are alarms.
void ptnthtm(const Fields& fields, Reading& reading) {
  const auto angle = [&](std::size_t i) {
    const bool good = std::string_view("NMO").find(fields.letter(i + 1)) != std::string_view::npos;
    const std::optional<double> degrees = fields.degrees_or_counts(i);
    return good && degrees ? std::optional(*degrees * kDegree) : std::nullopt;
  };
  const auto within = [](std::optional<double> value, double largest) {
    return value && std::abs(*value) <= largest ? value : std::nullopt;
  };
  if (const auto heading = angle(1)) reading.heading = as_heading(*heading);
  reading.pitch = within(angle(3), kTurn / 4);
  reading.roll = within(angle(5), kTurn / 2);
}

struct Kind {
  std::string_view name;
  void (*read)(const Fields&, Reading&);
};
constexpr std::array kKinds{
    Kind{"HDG", hdg}, Kind{"HDM", hdm}, Kind{"HDT", hdt},     Kind{"ROT", rot},
    Kind{"DPT", dpt}, Kind{"DBT", dbt}, Kind{"VTG", vtg},     Kind{"GGA", gga},
    Kind{"RMC", rmc}, Kind{"XDR", xdr}, Kind{"PASHR", pashr}, Kind{"PTNTHTM", ptnthtm},
};

std::string_view without_end(std::string_view line) {
  while (!line.empty() && (line.back() == '\r' || line.back() == '\n' || line.back() == ' '))
    line.remove_suffix(1);
  return line;
}

std::string_view without_tag_block(std::string_view line) {
  if (!line.starts_with('\\')) return line;
  const std::size_t end = line.find('\\', 1);
  return end == line.npos ? line : line.substr(end + 1);
}

bool is_printable(std::string_view text) {
  return std::ranges::all_of(text, [](char c) { return c >= ' ' && c <= '~'; });
}

// Two letters, which proprietary sentences lack.
std::uint32_t talker_of(std::string_view body) {
  if (body.starts_with('P') || body.size() < 2) return 0;
  return static_cast<std::uint32_t>(static_cast<unsigned char>(body[0]) << 8 |
                                    static_cast<unsigned char>(body[1]));
}

// The name without its talker.
std::string_view kind_of(std::string_view body) {
  const std::string_view name = body.substr(0, body.find(','));
  if (name.starts_with('P')) return name;
  return name.size() == 5 ? name.substr(2) : std::string_view();
}

}  // namespace

NmeaSentence decode_nmea(std::string_view line) {
  NmeaSentence sentence;
  const auto faulty = [&](NmeaFault fault) {
    sentence.fault = fault;
    return sentence;
  };
  line = without_tag_block(without_end(line));
  if (line.starts_with('!')) return faulty(NmeaFault::unused);  // of AIS
  if (!line.starts_with('$') || !is_printable(line)) return faulty(NmeaFault::not_nmea);
  const std::size_t star = line.rfind('*');
  const std::string_view body = line.substr(1, star == line.npos ? line.npos : star - 1);
  sentence.kind = kind_of(body);
  if (sentence.kind.empty()) return faulty(NmeaFault::not_nmea);
  if (star == line.npos) return faulty(NmeaFault::no_checksum);
  const std::string_view sum = line.substr(star + 1);
  const auto high = sum.size() == 2 ? hex_digit(sum[0]) : std::nullopt;
  const auto low = sum.size() == 2 ? hex_digit(sum[1]) : std::nullopt;
  if (!high || !low || checksum(body) != static_cast<unsigned>(16 * *high + *low))
    return faulty(NmeaFault::wrong_checksum);
  const auto kind = std::ranges::find(kKinds, sentence.kind, &Kind::name);
  if (kind == kKinds.end()) return faulty(NmeaFault::unused);
  try {
    kind->read(Fields(body), sentence.reading);
  } catch (const Malformed&) {
    sentence.reading = {};
    return faulty(NmeaFault::malformed);
  }
  sentence.reading.sender = talker_of(body);
  return sentence;
}

std::string nmea_line(std::string_view body) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  const unsigned sum = checksum(body);
  return '$' + std::string(body) + '*' + kDigits[sum >> 4] + kDigits[sum & 15] + "\r\n";
}

void NmeaLines::feed(std::string_view bytes) {
  pending_.erase(0, begin_);
  begin_ = 0;
  pending_ += bytes;
}

std::optional<std::string_view> NmeaLines::next() {
  // The standard's 82, as much again for a TAG block, and for proprietary sentences.
  constexpr std::size_t kLongest = 512;
  while (true) {
    const std::size_t end = pending_.find_first_of("\r\n", begin_);
    if (end == pending_.npos) {
      if (pending_.size() - begin_ > kLongest) {
        pending_.clear();
        begin_ = 0;
        skipping_ = true;
      }
      return std::nullopt;
    }
    const std::string_view line = std::string_view(pending_).substr(begin_, end - begin_);
    begin_ = end + 1;
    if (std::exchange(skipping_, false) || line.empty() || line.size() > kLongest) continue;
    return line;
  }
}

}  // namespace nadir::sensors
