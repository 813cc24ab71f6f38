// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The mosaics as rasters for GIS software.
#include <algorithm>
#include <iterator>
#include <opencv2/core.hpp>

#include "nadir/image_io/encode.hpp"
#include "products.hpp"

namespace nadir::record {
namespace {

constexpr int kSide = MosaicGrid::kTileSize;
constexpr int kStripRows = 32;  // a raster of 100 000 px is written with 13 MB
static_assert(kSide % kStripRows == 0);

std::uint64_t seen_px(const Tile& tile) {
  cv::Mat alpha;
  cv::extractChannel(tile.bgra, alpha, 3);
  return static_cast<std::uint64_t>(cv::countNonZero(alpha));
}

void extend(MosaicRaster& raster, const TilePlace& place, bool first) {
  if (first) {
    raster.first_column = place.column;
    raster.first_row = place.row;
  }
  const std::int32_t end_column = std::max(raster.first_column + raster.columns, place.column + 1);
  const std::int32_t end_row = std::max(raster.first_row + raster.rows, place.row + 1);
  raster.first_column = std::min(raster.first_column, place.column);
  raster.first_row = std::min(raster.first_row, place.row);
  raster.columns = end_column - raster.first_column;
  raster.rows = end_row - raster.first_row;
}

// Rows [top, top + strip.rows) of the tiles in one row of the raster.
void fill(cv::Mat& strip, const MosaicRaster& raster, std::int32_t tile_row, int top,
          const MosaicTiles& tiles) {
  strip.setTo(cv::Scalar::all(0));
  const std::uint32_t mosaic = raster.grid.mosaic;
  const auto end = tiles.lower_bound({mosaic, tile_row + 1, INT32_MIN});
  for (auto tile = tiles.lower_bound({mosaic, tile_row, INT32_MIN}); tile != end; ++tile) {
    const int left = (tile->first.column - raster.first_column) * kSide;
    tile->second->bgra.rowRange(top, top + strip.rows).copyTo(strip.colRange(left, left + kSide));
  }
}

}  // namespace

WorldFile MosaicRaster::world() const {
  WorldFile world = grid.world;
  const Eigen::Vector2d corner = grid.world(first_column * kSide, first_row * kSide);
  world.c = corner.x();
  world.f = corner.y();
  return world;
}

std::map<std::uint32_t, MosaicRaster> rasters(const Ledger& ledger, const MosaicTiles& tiles) {
  std::map<std::uint32_t, MosaicRaster> rasters;
  for (const auto& [place, tile] : tiles) {
    const auto grid = ledger.mosaics.find(place.mosaic);
    if (grid == ledger.mosaics.end()) continue;  // its first image could not be recorded
    const auto [raster, first] = rasters.try_emplace(place.mosaic);
    raster->second.grid = grid->second;
    extend(raster->second, place, first);
    raster->second.seen_px += seen_px(*tile);
  }
  return rasters;
}

bool write_mosaic(LooseFile& file, const MosaicRaster& raster, const MosaicTiles& tiles) {
  const int width = raster.columns * kSide, height = raster.rows * kSide;
  const auto sink = [&](ByteView piece) { return file.write(piece); };
  image_io::PngWriter png(width, height, 4, sink);
  cv::Mat strip(kStripRows, width, CV_8UC4);
  for (int row = 0; row < height; row += kStripRows) {
    fill(strip, raster, raster.first_row + row / kSide, row % kSide, tiles);
    if (!png.rows(strip)) return false;
  }
  return png.finish();
}

namespace {

// As WKT 1, which other programs than GDAL read as well.
std::string utm_wkt(const reference::UtmGrid& grid) {
  const std::string zone = std::to_string(grid.zone()) + (grid.is_north() ? "N" : "S");
  const std::string meridian = std::to_string(6 * grid.zone() - 183);
  return R"(PROJCS["WGS 84 / UTM zone )" + zone +
         R"(",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563,)"
         R"(AUTHORITY["EPSG","7030"]],AUTHORITY["EPSG","6326"]],)"
         R"(PRIMEM["Greenwich",0,AUTHORITY["EPSG","8901"]],)"
         R"(UNIT["degree",0.0174532925199433,AUTHORITY["EPSG","9122"]],AUTHORITY["EPSG","4326"]],)"
         R"(PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],)"
         R"(PARAMETER["central_meridian",)" +
         meridian +
         R"(],PARAMETER["scale_factor",0.9996],PARAMETER["false_easting",500000],)"
         R"(PARAMETER["false_northing",)" +
         (grid.is_north() ? "0" : "10000000") +
         R"(],UNIT["metre",1,AUTHORITY["EPSG","9001"]],AXIS["Easting",EAST],)"
         R"(AXIS["Northing",NORTH],AUTHORITY["EPSG",")" +
         std::to_string(grid.epsg()) + R"("]])";
}

std::string local_wkt(const Ledger& ledger) {
  const bool metric = survey_unit(ledger.scale()) == "metres";
  const std::string name = metric ? "nadir survey" : "nadir survey, unscaled";
  const std::string unit = metric ? R"(UNIT["metre",1])" : R"(UNIT["unscaled",1])";
  const bool north = ledger.axes == SurveyAxes::attitude;
  const std::string axes = north ? R"(AXIS["Easting",EAST],AXIS["Northing",NORTH])"
                                 : R"(AXIS["x",EAST],AXIS["y",NORTH])";
  return "LOCAL_CS[\"" + name + "\"," + unit + "," + axes + "]";
}

}  // namespace

std::string auxiliary_xml(const Ledger& ledger) {
  const std::string wkt = ledger.grid ? utm_wkt(*ledger.grid) : local_wkt(ledger);
  return "<PAMDataset>\n  <SRS dataAxisToSRSAxisMapping=\"1,2\">" + wkt +
         "</SRS>\n  <Metadata>\n    <MDI key=\"SCALE\">" + scale_text(ledger.scale()) +
         "</MDI>\n  </Metadata>\n</PAMDataset>\n";
}

}  // namespace nadir::record
