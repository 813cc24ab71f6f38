// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include "node.hpp"

#include <algorithm>

#include "nadir/image_io/decode.hpp"
#include "nadir/image_io/header.hpp"
#include "nadir/odometry/correspondence.hpp"

namespace nadir::revisit {
namespace {

std::vector<Eigen::Vector3d> in_camera(const SettledKeyFrame& key_frame) {
  const Rigid3 camera_from_survey = key_frame.pose.survey_from_camera.inverse();
  std::vector<Eigen::Vector3d> points;
  points.reserve(key_frame.observations.size());
  for (const auto& o : key_frame.observations) {
    points.push_back(camera_from_survey * o.x_in_survey);
  }
  return points;
}

odometry::DepthPrior prior_of(const std::vector<Eigen::Vector3d>& points) {
  std::vector<odometry::DepthSample> samples;
  samples.reserve(points.size());
  for (const auto& x : points) {
    if (x.z() > 0) samples.push_back({x.hnormalized(), 1 / x.z()});
  }
  return odometry::DepthPrior(std::move(samples));
}

double median_depth(const std::vector<Eigen::Vector3d>& points) {
  std::vector<double> depths;
  depths.reserve(points.size());
  for (const auto& x : points) {
    if (x.z() > 0) depths.push_back(x.z());
  }
  if (depths.empty()) return 0;
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return *middle;
}

}  // namespace

Node::Node(const SettledKeyFrame& key_frame)
    : image(key_frame.pose.image),
      submap(key_frame.pose.submap),
      rig(key_frame.rig),
      live(key_frame.pose.survey_from_camera),
      corrected_from_camera{1, live},
      metric(std::ranges::any_of(key_frame.observations,
                                 [](const auto& o) { return o.right_ray.has_value(); })),
      upright(key_frame.axes == SurveyAxes::attitude || key_frame.axes == SurveyAxes::poses),
      features(key_frame.features),
      picture(key_frame.picture),
      observations(key_frame.observations),
      prior(prior_of(in_camera(key_frame))),
      depth(median_depth(in_camera(key_frame))) {}

const Features& Node::find_blobs() {
  if (blobs) return *blobs;
  blobs.emplace();
  const auto [header, fault] = image_io::read_header(picture);
  if (!header) return *blobs;
  const cv::Mat grey =
      image_io::decode(picture, header->width, header->height, 1, image_io::Colour::grey).image;
  if (!grey.empty()) blobs = odometry::describe_blobs(grey, rig->left);
  return *blobs;
}

}  // namespace nadir::revisit
