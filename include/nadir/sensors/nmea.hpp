// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// NMEA 0183 sentences of compasses, AHRS, sounders and receivers (IEC 61162-1).
#pragma once

#include <string>
#include <string_view>

#include "nadir/sensors/reading.hpp"

namespace nadir::sensors {

enum class NmeaFault {
  none,
  not_nmea,        ///< no '$' in front, a byte outside printable ASCII, or too short
  no_checksum,     ///< a sentence that cannot be trusted
  wrong_checksum,  ///< damaged on the way
  unused,          ///< a sentence of a kind that says nothing of use here
  malformed,       ///< a used kind with a field that is no number of its kind
};

struct NmeaSentence {
  NmeaFault fault = NmeaFault::none;
  std::string kind;  ///< HDT, or PASHR for a proprietary one; empty when not_nmea
  Reading reading;   ///< empty unless fault is none
};

/// One line with or without its end, and with or without a TAG block (\...\) in front.
/// Used, of any talker: HDG HDM HDT ROT DPT DBT VTG GGA RMC XDR, and PASHR, PTNTHTM.
/// DPT and DBT: below the transducer is altitude. XDR: ROLL or HEEL, PITCH, PTCH or TRIM, and
/// DEPTH.
NmeaSentence decode_nmea(std::string_view line);

/// $BODY*hh and the line's end; body without '$'.
std::string nmea_line(std::string_view body);

/// The lines of a stream of bytes. What is longer than any sentence is passed over to its end.
class NmeaLines {
 public:
  void feed(std::string_view bytes);
  /// The next whole line without its end, valid until the next call; none when more bytes are
  /// needed. Empty lines are passed over.
  std::optional<std::string_view> next();

 private:
  std::string pending_;
  std::size_t begin_ = 0;  ///< of the first line not handed out
  bool skipping_ = false;
};

}  // namespace nadir::sensors
