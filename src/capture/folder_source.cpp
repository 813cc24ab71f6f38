// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "nadir/capture/folder_source.hpp"

#include <opencv2/imgproc.hpp>

#include "beside.hpp"
#include "file.hpp"
#include "image_list.hpp"
#include "image_times.hpp"
#include "nadir/core/check.hpp"
#include "nadir/image_io/decode.hpp"
#include "nadir/image_io/header.hpp"
#include "survey_sensors.hpp"

namespace nadir::capture {

namespace fs = std::filesystem;

struct FolderSource::State {
  ImageList list;
  std::vector<ImageTime> times;
  CameraRig full_rig;
  int divisor = 1;
  std::shared_ptr<const CameraRig> rig;
  std::optional<calibration::Lasers> lasers;
  std::optional<SurveySensors> sensors;
  std::size_t next_image = 0;

  /// The fault of the pair or of one of its files, named; empty when the frame's images were read.
  std::string read_images(std::size_t image, Frame& frame) const;
  /// To be called with each image, read or not.
  void finish_sensors(std::vector<Alert>& alerts);
};

namespace {

CameraRig load_rig(const fs::path& folder, const std::optional<fs::path>& calibration,
                   const ImageList& list) {
  const fs::path file = calibration_file(folder, calibration);
  CameraRig rig = load_calibration(file);
  if (!list.is_stereo()) rig.right.reset();
  if (list.is_stereo() && !rig.right) {
    throw InputError(file.string() +
                     ": calibrates one camera, but there are images/left and images/right; add "
                     "camera_matrix_right, distortion_coefficients_right, R and T, or remove "
                     "images/right");
  }
  return rig;
}

// No file of an image can be larger than its raw pixels with 16 bits and alpha, and some metadata.
std::uint64_t most_bytes(const CameraModel& camera) {
  constexpr std::uint64_t kMetadata = 64u << 20;
  return std::uint64_t{8} * static_cast<std::uint64_t>(camera.width) *
             static_cast<std::uint64_t>(camera.height) +
         kMetadata;
}

image_io::Decoded read_picture(const fs::path& file, const CameraModel& camera, int divisor,
                               image_io::Colour colour) {
  const FileBytes read = read_file(file, most_bytes(camera), Links::refuse);
  if (!read.fault.empty()) return {{}, read.fault};
  return image_io::decode(read.bytes, camera.width, camera.height, divisor, colour);
}

std::string fault_of_header(const fs::path& file, const CameraModel& camera) {
  const FileBytes read = read_file(file, most_bytes(camera), Links::refuse);
  if (!read.fault.empty()) return read.fault;
  const auto [header, fault] = image_io::read_header(read.bytes);
  if (!header) return fault;
  if (header->width == camera.width && header->height == camera.height) return {};
  return "is " + std::to_string(header->width) + " x " + std::to_string(header->height) +
         " px, the calibration is for " + std::to_string(camera.width) + " x " +
         std::to_string(camera.height) + " px";
}

// A wrong calibration must not look like a dive of nothing but damaged images.
void require_a_fitting_image(const ImageList& list, const CameraRig& rig) {
  std::string first_fault;
  for (const ImageFiles& files : list.images) {
    if (files.left.empty() || (rig.right && files.right.empty())) continue;
    fs::path file = list.left_folder / files.left;
    std::string fault = fault_of_header(file, rig.left);
    if (fault.empty() && rig.right) {
      file = list.right_folder / files.right;
      fault = fault_of_header(file, rig.right->camera);
    }
    if (fault.empty()) return;
    if (first_fault.empty()) first_fault = printable(file.string()) + ": " + fault;
  }
  if (first_fault.empty()) {
    throw InputError(list.left_folder.string() + ": no image has a partner of the same name in " +
                     list.right_folder.string());
  }
  throw InputError(first_fault +
                   "; no other image can be used either: give images as the calibrated camera "
                   "stored them, or the calibration of this camera and image size");
}

}  // namespace

FolderSource::FolderSource(const fs::path& folder, const std::optional<fs::path>& calibration,
                           const Config& config)
    : state_(std::make_unique<State>()) {
  config.check();
  State& s = *state_;
  s.list = list_images(folder);
  s.full_rig = load_rig(folder, calibration, s.list);
  s.full_rig.body_from_camera = config.body_from_camera();
  s.divisor = config.divisor();
  s.rig = std::make_shared<const CameraRig>(s.full_rig.reduced(s.divisor));
  require_a_fitting_image(s.list, s.full_rig);
  s.times = image_times(folder, s.list);
  s.sensors.emplace(folder);
  s.lasers = lasers_beside(folder);
}

FolderSource::~FolderSource() = default;

std::size_t FolderSource::size() const { return state_->list.images.size(); }
std::vector<ListedImage> FolderSource::images() const {
  std::vector<ListedImage> images;
  for (std::size_t i = 0; i < size(); ++i) {
    const ImageTime& time = state_->times[i];
    images.push_back({printable(state_->list.stem(i)),
                      time.fault.empty() ? std::optional(time.time) : std::nullopt});
  }
  return images;
}
std::shared_ptr<const CameraRig> FolderSource::rig() const { return state_->rig; }
bool FolderSource::is_stereo() const { return state_->list.is_stereo(); }
const std::optional<calibration::Lasers>& FolderSource::lasers() const { return state_->lasers; }

std::string FolderSource::State::read_images(std::size_t image, Frame& frame) const {
  const ImageFiles& files = list.images[image];
  const bool stereo = list.is_stereo();
  const std::string left = (stereo ? "left/" : "") + printable(files.left) + ": ";
  const std::string right = "right/" + printable(files.right) + ": ";
  if (files.left.empty()) return right + "has no left image";
  if (stereo && files.right.empty()) return left + "has no right image";
  if (!times[image].fault.empty()) return left + times[image].fault;

  image_io::Decoded picture =
      read_picture(list.left_folder / files.left, full_rig.left, divisor, image_io::Colour::bgr);
  if (!picture.fault.empty()) return left + picture.fault;
  frame.colour = std::move(picture.image);
  cv::cvtColor(frame.colour, frame.grey, cv::COLOR_BGR2GRAY);
  if (!stereo) return {};
  picture = read_picture(list.right_folder / files.right, full_rig.right->camera, divisor,
                         image_io::Colour::grey);
  if (!picture.fault.empty()) return right + picture.fault;
  frame.right = std::move(picture.image);
  return {};
}

void FolderSource::State::finish_sensors(std::vector<Alert>& alerts) {
  if (next_image == list.images.size()) sensors->finish(alerts);
}

std::optional<Shot> FolderSource::next() {
  State& s = *state_;
  if (s.next_image == s.list.images.size()) return std::nullopt;
  const std::size_t image = s.next_image++;
  Shot shot{image, s.times[image].time, printable(s.list.stem(image)), nullptr, {}, 0};
  shot.alerts = s.sensors->new_faults(shot.time);
  Frame frame;
  const std::string fault = s.read_images(image, frame);
  if (!fault.empty()) {
    shot.alerts.push_back({shot.time, image, AlertKind::image_rejected, fault,
                           "the dive goes on without it; correct the file to map it later"});
    s.finish_sensors(shot.alerts);
    return shot;
  }
  frame.image = image;
  frame.time = shot.time;
  frame.name = shot.name;
  frame.rig = s.rig;
  s.sensors->read(frame, shot.alerts);
  s.finish_sensors(shot.alerts);
  shot.frame = std::make_shared<const Frame>(std::move(frame));
  return shot;
}

}  // namespace nadir::capture
