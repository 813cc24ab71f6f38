// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "beam.hpp"
#include "nadir/core/check.hpp"
#include "nadir/reference/laser_scale.hpp"
#include "spot.hpp"

namespace nadir::reference {
namespace {

using calibration::LaserColour, calibration::Lasers;
using Eigen::Vector2d, Eigen::Vector3d;

constexpr double kNearest = 0.3, kFarthest = 15;  // metres along the beam

// Mountings and calibrations are not exact: a dot may lie this much beside its line.
constexpr double kBeside = 0.005;  // radians
constexpr double kBeside_px = 0.7;

// Of the colour's linear light over the other two's; the scale is 0 to 255.
constexpr double kMinPeak = 12;       // at all a candidate, when smoothed
constexpr double kMinAmplitude = 20;  // of a spot
constexpr double kMinContrast = 5;    // amplitude over the residuals of the fit
constexpr double kMinSigma_px = 0.5;
constexpr double kMinSigma = 0.4e-3, kMaxSigma = 20e-3;  // metres; laser pointers have 1 to 3 mm
constexpr std::size_t kMaxCandidates = 12;               // per beam, the brightest: fits cost time

// Two dots on one seabed from two equal lasers.
constexpr double kRelief = 0.15;  // of the distance
constexpr double kMaxWidths = 2, kMaxAmplitudes = 5;

// A camera's tone curve is near this, and what a laser adds to the lamps' light is added before it.
constexpr double kGamma = 2.2;
constexpr int kClipped = 252;  // JPEG moves 255 a little

struct Place {
  double distance = 0;  ///< along the beam
  double beside = 0;    ///< from the beam's image, of the focal length
};

// Where along its beam a dot seen along a ray lies: from (o + t d).xy = ray (o + t d).z by least
// squares.
std::optional<Place> place_on(const Beam& beam, const Vector2d& ray) {
  const Vector2d a = beam.origin.head<2>() - ray * beam.origin.z();
  const Vector2d b = beam.direction.head<2>() - ray * beam.direction.z();
  if (b.squaredNorm() < 1e-12) return std::nullopt;
  const double t = -a.dot(b) / b.squaredNorm();
  const double z = beam.at(t).z();
  if (!(t >= kNearest && t <= kFarthest && z > 0)) return std::nullopt;
  return Place{t, (a + t * b).norm() / z};
}

double beside_allowed(const CameraModel& camera) { return kBeside + kBeside_px / camera.fx; }

// The part of the image where the dots may be.
cv::Rect region_of(const std::array<Beam, 2>& beams, const CameraModel& camera, int margin) {
  constexpr int kSteps = 200;
  std::vector<cv::Point> seen;
  for (const Beam& beam : beams) {
    for (int i = 0; i <= kSteps; ++i) {
      const double t = kNearest * std::pow(kFarthest / kNearest, static_cast<double>(i) / kSteps);
      const auto pixel = camera.project(beam.at(t));
      if (!pixel || pixel->minCoeff() < 0 || pixel->x() > camera.width - 1 ||
          pixel->y() > camera.height - 1) {
        continue;
      }
      seen.emplace_back(static_cast<int>(std::lround(pixel->x())),
                        static_cast<int>(std::lround(pixel->y())));
    }
  }
  if (seen.empty()) return {};
  const cv::Rect box = cv::boundingRect(seen);
  return (box + cv::Size(2 * margin, 2 * margin) - cv::Point(margin, margin)) &
         cv::Rect(0, 0, camera.width, camera.height);
}

struct Excess {
  cv::Mat1f colour;  ///< linear light of the laser's colour over the mean of the other two
  /// Over half that mean: still little of what lamps light, and less of the other two's shape,
  /// which JPEG keeps at half the resolution and a clipped centre bends.
  cv::Mat1f light;
  cv::Mat1b at_least;  ///< not 0 where the laser's colour is clipped
};

Excess excess_of(const cv::Mat3b& bgr, LaserColour colour) {
  static const std::array<float, 256> kLinear = [] {
    std::array<float, 256> linear{};
    for (std::size_t i = 0; i < linear.size(); ++i) {
      linear[i] = static_cast<float>(255 * std::pow(static_cast<double>(i) / 255, kGamma));
    }
    return linear;
  }();
  const int own = colour == LaserColour::blue ? 0 : colour == LaserColour::green ? 1 : 2;
  const int second = (own + 1) % 3, third = (own + 2) % 3;
  Excess excess{cv::Mat1f(bgr.size()), cv::Mat1f(bgr.size()), cv::Mat1b(bgr.size())};
  for (int y = 0; y < bgr.rows; ++y) {
    for (int x = 0; x < bgr.cols; ++x) {
      const cv::Vec3b& pixel = bgr(y, x);
      const float others = 0.5f * (kLinear[pixel[second]] + kLinear[pixel[third]]);
      excess.colour(y, x) = kLinear[pixel[own]] - others;
      excess.light(y, x) = kLinear[pixel[own]] - 0.5f * others;
      excess.at_least(y, x) = pixel[own] >= kClipped ? 255 : 0;
    }
  }
  return excess;
}

std::vector<cv::Point> peaks(const cv::Mat1f& light) {
  constexpr double kSigma_px = 1.5;
  constexpr int kApart_px = 5;
  cv::Mat1f smooth, highest;
  cv::GaussianBlur(light, smooth, {}, kSigma_px);
  cv::dilate(smooth, highest, cv::Mat::ones(kApart_px, kApart_px, CV_8U));
  const cv::Mat found = (smooth >= highest) & (smooth > kMinPeak);
  std::vector<cv::Point> peaks;
  cv::findNonZero(found, peaks);
  std::sort(peaks.begin(), peaks.end(),
            [&](const cv::Point& a, const cv::Point& b) { return smooth(a) > smooth(b); });
  return peaks;
}

struct Candidate {
  Spot spot;
  LaserDot dot;
};

bool is_dot(const Spot& spot, double sigma) {
  return sigma > kMinSigma && sigma < kMaxSigma && spot.amplitude > kMinAmplitude &&
         spot.amplitude > kMinContrast * spot.rms && spot.sigma > kMinSigma_px;
}

// A disc large enough to see the background, small enough to leave out the other dot.
std::optional<Spot> fit_colour(const Excess& excess, const Vector2d& start, double apart_px) {
  constexpr double kUsual_px = 9;     // of spots with a sigma of 1 to 3 px
  constexpr double kLargest_px = 40;  // fits cost time
  const double largest = std::min(0.45 * apart_px, kLargest_px);
  auto spot = fit_spot(excess.colour, excess.at_least, start, std::min(kUsual_px, largest));
  if (spot && 4 * spot->sigma > kUsual_px && largest > kUsual_px) {
    spot =
        fit_spot(excess.colour, excess.at_least, spot->centre, std::min(4 * spot->sigma, largest));
  }
  return spot;
}

// The core of the spot, within the halo that water and lens make of it. Measured on gravel: 0.19 px
// per axis, and the two dots 0.03 px too near to each other; 0.05 to 0.08 px by colour alone.
Vector2d centre_of(const Excess& excess, const Spot& spot) {
  constexpr double kMost_px = 1;
  const auto core = fit_spot(excess.light, excess.at_least, spot.centre, 2.5 * spot.sigma);
  return core && (core->centre - spot.centre).norm() < kMost_px ? core->centre : spot.centre;
}

// Where the amplitude has fallen to what the darkest seabed hides.
double radius_of(const Spot& spot) {
  constexpr double kInvisible = 0.5;  // of 255, linear light
  return 1 + spot.sigma * std::sqrt(2 * std::log(std::max(spot.amplitude / kInvisible, 2.0)));
}

std::vector<Candidate> candidates_on(const Beam& beam, double separation, const Excess& excess,
                                     const std::vector<cv::Point>& peaks, const cv::Point& corner,
                                     const CameraModel& camera) {
  const Vector2d shift(corner.x, corner.y);
  std::vector<Candidate> candidates;
  std::size_t tried = 0;
  for (const cv::Point& peak : peaks) {
    const Vector2d start(peak.x, peak.y);
    const auto towards = camera.unproject(start + shift);
    const auto about = towards ? place_on(beam, *towards) : std::nullopt;
    const double a_pixel = 1 / camera.fx;
    if (!about || about->beside > beside_allowed(camera) + a_pixel) continue;
    if (++tried > kMaxCandidates) break;
    const auto spot =
        fit_colour(excess, start, camera.fx * separation / beam.at(about->distance).z());
    if (!spot || !is_dot(*spot, spot->sigma * a_pixel * beam.at(about->distance).z())) continue;
    const Vector2d pixel = centre_of(excess, *spot) + shift;
    const auto ray = camera.unproject(pixel);
    const auto place = ray ? place_on(beam, *ray) : std::nullopt;
    if (!place || place->beside > beside_allowed(camera)) continue;
    candidates.push_back({*spot, {pixel, *ray, place->distance, radius_of(*spot)}});
  }
  return candidates;
}

bool alike(double a, double b, double ratio) { return a < ratio * b && b < ratio * a; }

bool are_a_pair(const Candidate& a, const Candidate& b) {
  const double nearer = std::min(a.dot.distance, b.dot.distance);
  return std::abs(a.dot.distance - b.dot.distance) < kRelief * nearer &&
         alike(a.spot.sigma, b.spot.sigma, kMaxWidths) &&
         alike(a.spot.amplitude, b.spot.amplitude, kMaxAmplitudes) &&
         (a.dot.pixel - b.dot.pixel).norm() > 2 * (a.spot.sigma + b.spot.sigma);
}

}  // namespace

std::array<Beam, 2> beams_of(const Lasers& lasers) {
  NADIR_CHECK(fault_of(lasers).empty());
  const Vector3d direction = lasers.direction_in_camera.value_or(Vector3d::UnitZ());
  return {{{lasers.origins_in_camera[0], direction}, {lasers.origins_in_camera[1], direction}}};
}

Vector3d across(const std::array<Beam, 2>& beams) {
  const Vector3d between = beams[1].origin - beams[0].origin;
  return between - beams[0].direction * beams[0].direction.dot(between);
}

namespace {

std::string contradiction(double apart, const Lasers& lasers) {
  return "the beams are " + std::to_string(apart) + " m apart by origins_camera_m and " +
         std::to_string(lasers.separation) + " m by separation_m: correct one";
}

}  // namespace

std::string fault_of(const Lasers& lasers) {
  constexpr double kMostApart = 0.25;  // relative; the dots are looked for by the origins
  if (lasers.origins_in_camera.size() != 2) {
    return "scale is taken from two lasers of known place: give origins_camera_m of two";
  }
  if (!lasers.direction_in_camera && !lasers.parallel_to_optical_axis) {
    return "the direction of the beams is not given: give direction_camera, or set "
           "parallel_to_optical_axis";
  }
  const Vector3d direction = lasers.direction_in_camera.value_or(Vector3d::UnitZ());
  if (!(direction.z() > 0.5)) {
    return "the beams do not point where the camera looks: correct direction_camera";
  }
  const Vector3d& origin = lasers.origins_in_camera[0];
  const Vector3d& other = lasers.origins_in_camera[1];
  const double apart = across({{{origin, direction}, {other, direction}}}).norm();
  if (!(std::abs(apart / lasers.separation - 1) < kMostApart)) return contradiction(apart, lasers);
  return {};
}

std::string conflict_of(const Lasers& lasers) {
  constexpr double kTolerance = 0.02;  // a ruler and a calibration differ by less
  const double apart = across(beams_of(lasers)).norm();
  if (std::abs(apart / lasers.separation - 1) < kTolerance) return {};
  return contradiction(apart, lasers);
}

std::optional<LaserDots> find_laser_dots(const Frame& frame, const Lasers& lasers) {
  const std::array<Beam, 2> beams = beams_of(lasers);
  const CameraModel& camera = frame.rig->left;
  NADIR_CHECK(frame.colour.type() == CV_8UC3 && frame.colour.cols == camera.width &&
                  frame.colour.rows == camera.height,
              frame.colour.cols, frame.colour.rows);
  const cv::Rect region = region_of(beams, camera, static_cast<int>(0.05 * camera.fx));
  if (region.empty()) return std::nullopt;
  const Excess excess = excess_of(cv::Mat3b(frame.colour)(region), lasers.colour);
  const std::vector<cv::Point> bright = peaks(excess.colour);
  std::array<std::vector<Candidate>, 2> found;
  for (std::size_t i = 0; i < 2; ++i) {
    found[i] = candidates_on(beams[i], lasers.separation, excess, bright, region.tl(), camera);
  }
  std::optional<LaserDots> best;
  double brightest = 0;
  for (const Candidate& a : found[0]) {
    for (const Candidate& b : found[1]) {
      const double amplitude = std::min(a.spot.amplitude, b.spot.amplitude);
      if (amplitude <= brightest || !are_a_pair(a, b)) continue;
      brightest = amplitude;
      best = LaserDots{frame.image, {a.dot, b.dot}};
    }
  }
  return best;
}

// How far a dot moves with the distance along its beam says how well the distance is known.
std::vector<Range> ranges_of(const LaserDots& dots, const calibration::Lasers& lasers,
                             const CameraModel& camera) {
  constexpr double kDot_px = 0.2;
  const std::array<Beam, 2> beams = beams_of(lasers);
  std::vector<Range> ranges;
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const LaserDot& dot = dots.dots[i];
    const double depth = beams[i].at(dot.distance).z();
    const Eigen::Vector3d& along = beams[i].direction;
    const Eigen::Vector2d by_distance = (along.head<2>() - dot.ray * along.z()) / depth;
    const double moved_px = camera.mean_focal() * by_distance.norm() * dot.distance;
    if (depth > 0 && moved_px > 0) ranges.push_back({dot.ray, depth, kDot_px / moved_px});
  }
  return ranges;
}

}  // namespace nadir::reference
