// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The point clouds: binary little-endian PLY, streamed from the journal.
#include <cstring>

#include "products.hpp"

namespace nadir::record {
namespace {

// Up to here single precision is good to a quarter of a millimetre.
constexpr double kFarthestInFloat = 4096;

class PlyWriter {
 public:
  PlyWriter(LooseFile& file, const Ledger& ledger, std::uint64_t vertices,
            const std::string& last_properties)
      : file_(file), expected_(vertices), wide_(ledger.farthest > kFarthestInFloat) {
    const std::string real = wide_ ? "double" : "float";
    file.write("ply\nformat binary_little_endian 1.0\ncomment survey frame, " +
               scale_text(ledger.scale()) + "\nelement vertex " + std::to_string(vertices) +
               "\nproperty " + real + " x\nproperty " + real + " y\nproperty " + real +
               " z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n" +
               last_properties + "end_header\n");
  }

  template <class... Last>
  void point(const Eigen::Vector3d& x, const std::array<std::uint8_t, 3>& rgb,
             const Last&... last) {
    wide_ ? packed(as<double>(x), rgb, last...) : packed(as<float>(x), rgb, last...);
    ++written_;
  }

  // The header promised a number; the journal may have gone bad since it was counted.
  bool whole() const { return written_ == expected_; }

 private:
  template <class Real>
  static std::array<Real, 3> as(const Eigen::Vector3d& x) {
    return {static_cast<Real>(x.x()), static_cast<Real>(x.y()), static_cast<Real>(x.z())};
  }

  template <class... Values>
  void packed(const Values&... values) {
    std::array<std::uint8_t, (sizeof(Values) + ...)> bytes;
    std::uint8_t* to = bytes.data();
    ((std::memcpy(to, &values, sizeof values), to += sizeof values), ...);
    file_.write(bytes);
  }

  LooseFile& file_;
  std::uint64_t expected_, written_ = 0;
  bool wide_;
};

template <class Each>
void for_each_shot(const path& dive, bool pixels, Each each) {
  JournalReader journal(dive);
  while (const auto record = journal.next()) {
    if (record->type != RecordType::shot) continue;
    auto facts = decode_facts(record->payload, pixels);
    if (!facts && pixels) facts = decode_facts(record->payload, false);  // rather black than lost
    if (facts) each(*facts, record->sequence);
  }
}

}  // namespace

bool write_sparse(LooseFile& file, const Ledger& ledger, const path& dive) {
  PlyWriter ply(file, ledger, ledger.tie_points.size(),
                "property uint observations\nproperty uint submap\n");
  for_each_shot(dive, false, [&](const Facts& facts, std::uint64_t sequence) {
    if (!facts.window) return;
    const Similarity3 correction = ledger.corrections.at(facts.window->submap, facts.image);
    for (const TiePoint& point : facts.window->tie_points) {
      const auto newest = ledger.tie_points.find(point.id);
      if (newest == ledger.tie_points.end() || newest->second != sequence) continue;
      ply.point(correction * point.x_in_survey, point.rgb, point.images, facts.window->submap);
    }
  });
  return ply.whole();
}

bool write_projection3d(LooseFile& file, const Ledger& ledger, const path& dive) {
  PlyWriter ply(file, ledger, ledger.grid_points, "property uint image\n");
  for_each_shot(dive, true, [&](const Facts& facts, std::uint64_t) {
    if (!facts.grid) return;
    const Similarity3 correction = ledger.corrections.at(facts.grid->submap, facts.grid->image);
    for (const CloudPoint& point : facts.grid->points()) {
      ply.point(correction * point.x_in_survey, point.rgb,
                static_cast<std::uint32_t>(facts.grid->image));
    }
  });
  return ply.whole();
}

}  // namespace nadir::record
