#include "ortho/seam_search.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc/detail/gcgraph.hpp>
#include <optional>

#include "core/base/median.h"

namespace orient::ortho {
namespace {

constexpr double kStrip = 0.25;  // of the distance of two nadirs, on either side of their bisector
// Costs of a seam through a cell without any difference, and of giving a cell at the strip's border
// to the photo that is farther away (less towards the middle), as shares of the usual difference:
// without a reason, lines stay short and near the middle.
constexpr double kLength = 0.2, kFarther = 0.2;

MapGrid Around(const std::vector<PhotoCells>& cells) {
  MapGrid all = cells.front().grid;
  for (const PhotoCells& photo : cells) all = all.With(photo.grid);
  return all;
}

// Which cells each photo may still show.
class Shares {
 public:
  Shares(const std::vector<SeamPhoto>& photos, const std::vector<PhotoCells>& cells)
      : photos_(photos), cells_(cells), grid_(Around(cells)) {
    FindNearest();
    for (std::size_t i = 0; i < cells.size(); ++i) may_.push_back(MayShow(i));
  }

  bool Has(std::size_t photo, int col, int row) const {
    const MapGrid& grid = cells_[photo].grid;
    return col >= 0 && row >= 0 && col < grid.width && row < grid.height &&
           may_[photo][Index(grid, col, row)];
  }
  void Take(std::size_t photo, int col, int row) {
    may_[photo][Index(cells_[photo].grid, col, row)] = false;
  }
  // Distance of a place beyond the perpendicular bisector of two nadirs, seen from the first, in
  // half widths of the strip; negative on its own side. 0 if the nadirs coincide.
  double Beyond(std::size_t first, std::size_t second, const Eigen::Vector2d& at) const {
    const Eigen::Vector2d &own = photos_[first].nadir_m, &other = photos_[second].nadir_m;
    const double base = (own - other).squaredNorm();
    if (base == 0) return 0;
    return ((at - own).squaredNorm() - (at - other).squaredNorm()) / (2 * kStrip * base);
  }
  const MapGrid& Grid() const { return grid_; }

  // The photo of each of the grid's cells, -1 if none shows it.
  std::vector<int> Photos() const {
    std::vector<int> shown(nearest_.size(), -1);
    ForEachCell([&](std::size_t photo, int col, int row, std::size_t place) {
      if (Has(photo, col, row)) shown[place] = static_cast<int>(photo);
    });
    return shown;
  }

 private:
  static std::size_t Index(const MapGrid& grid, int col, int row) {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.width) +
           static_cast<std::size_t>(col);
  }

  std::size_t PlaceOf(std::size_t photo, int col, int row) const {
    const MapGrid& grid = cells_[photo].grid;
    return Index(grid_, static_cast<int>(col + grid.west - grid_.west),
                 static_cast<int>(row + grid_.north - grid.north));
  }

  template <typename Visit>
  void ForEachCell(const Visit& visit) const {
    for (std::size_t photo = 0; photo < cells_.size(); ++photo)
      for (int row = 0; row < cells_[photo].grid.height; ++row)
        for (int col = 0; col < cells_[photo].grid.width; ++col)
          if (cells_[photo].Has(col, row)) visit(photo, col, row, PlaceOf(photo, col, row));
  }

  void FindNearest() {
    nearest_.assign(Index(grid_, 0, grid_.height), -1);
    ForEachCell([&](std::size_t photo, int col, int row, std::size_t place) {
      const Eigen::Vector2d at = cells_[photo].grid.GroundFromPixel(col + 0.5, row + 0.5);
      const int other = nearest_[place];
      if (other < 0 || (at - photos_[photo].nadir_m).squaredNorm() <
                           (at - photos_[static_cast<std::size_t>(other)].nadir_m).squaredNorm())
        nearest_[place] = static_cast<int>(photo);
    });
  }

  // The cells where the photo is the nearest, or in the strip between it and the nearest one.
  std::vector<bool> MayShow(std::size_t photo) const {
    const MapGrid& grid = cells_[photo].grid;
    std::vector<bool> may(Index(grid, 0, grid.height), false);
    for (int row = 0; row < grid.height; ++row)
      for (int col = 0; col < grid.width; ++col) {
        if (!cells_[photo].Has(col, row)) continue;
        const auto nearest = static_cast<std::size_t>(nearest_[PlaceOf(photo, col, row)]);
        may[Index(grid, col, row)] =
            photo == nearest ||
            (photos_[photo].nadir_m != photos_[nearest].nadir_m &&
             Beyond(photo, nearest, grid.GroundFromPixel(col + 0.5, row + 0.5)) <= 1);
      }
    return may;
  }

  const std::vector<SeamPhoto>& photos_;
  const std::vector<PhotoCells>& cells_;
  MapGrid grid_;
  std::vector<int> nearest_;  // photo of each place, -1: none shows it
  std::vector<std::vector<bool>> may_;
};

// The seam between two photos across the cells that both may show.
class PairCut {
 public:
  PairCut(const std::vector<PhotoCells>& cells, std::size_t first, std::size_t second,
          Shares* shares)
      : first_(cells[first]),
        second_(cells[second]),
        photo_{first, second},
        common_(Common(first_.grid, second_.grid)),
        shares_(shares) {}

  void Do() {
    FindCells();
    if (nodes_.empty()) return;
    MeasureDifferences();
    Graph graph(static_cast<unsigned>(nodes_.size()), static_cast<unsigned>(4 * nodes_.size()));
    for (std::size_t i = 0; i < nodes_.size(); ++i) graph.addVtx();
    for (std::size_t i = 0; i < nodes_.size(); ++i) Connect(static_cast<int>(i), &graph);
    graph.maxFlow();
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const Node& node = nodes_[i];
      if (graph.inSourceSegment(static_cast<int>(i)))
        shares_->Take(photo_[1], node.col + common_.in_second.col,
                      node.row + common_.in_second.row);
      else
        shares_->Take(photo_[0], node.col + common_.in_first.col, node.row + common_.in_first.row);
    }
  }

 private:
  using Graph = cv::detail::GCGraph<double>;
  struct Node {
    int col, row;  // in the common window
    double difference = 0;
  };

  bool HasFirst(int col, int row) const {
    return shares_->Has(photo_[0], col + common_.in_first.col, row + common_.in_first.row);
  }
  bool HasSecond(int col, int row) const {
    return shares_->Has(photo_[1], col + common_.in_second.col, row + common_.in_second.row);
  }

  void FindCells() {
    const int width = common_.in_first.width, height = common_.in_first.height;
    numbers_.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), -1);
    for (int row = 0; row < height; ++row)
      for (int col = 0; col < width; ++col) {
        if (!HasFirst(col, row) || !HasSecond(col, row)) continue;
        numbers_[Index(col, row)] = static_cast<int>(nodes_.size());
        nodes_.push_back({col, row});
      }
  }

  std::size_t Index(int col, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(common_.in_first.width) +
           static_cast<std::size_t>(col);
  }
  int NumberAt(int col, int row) const {
    const bool inside =
        col >= 0 && row >= 0 && col < common_.in_first.width && row < common_.in_first.height;
    return inside ? numbers_[Index(col, row)] : -1;
  }

  void MeasureDifferences() {
    for (std::size_t band = 0; band < first_.bands.size(); ++band) {
      std::vector<double> differences;
      for (const Node& node : nodes_)
        differences.push_back(
            static_cast<double>(first_.bands[band].At(node.col + common_.in_first.col,
                                                      node.row + common_.in_first.row)) -
            static_cast<double>(second_.bands[band].At(node.col + common_.in_second.col,
                                                       node.row + common_.in_second.row)));
      const double usual = Median(differences);
      for (std::size_t i = 0; i < nodes_.size(); ++i)
        nodes_[i].difference += std::abs(differences[i] - usual);
    }
    std::vector<double> all;
    for (const Node& node : nodes_) all.push_back(node.difference);
    constexpr double kLeast = 1e-6;  // grey values, of photos that are the same
    usual_ = std::max(Median(all), kLeast);
  }

  // Connects a cell to the next ones to the right and below, and to what only one photo may show.
  void Connect(int number, Graph* graph) const {
    const Node& node = nodes_[static_cast<std::size_t>(number)];
    for (const auto& [right, down] : {std::pair{1, 0}, std::pair{0, 1}}) {
      const int next = NumberAt(node.col + right, node.row + down);
      if (next < 0) continue;
      const double cost =
          node.difference + nodes_[static_cast<std::size_t>(next)].difference + kLength * usual_;
      graph->addEdges(number, next, cost, cost);
    }
    double to_first = 0, to_second = 0;
    for (const auto& [right, down] :
         {std::pair{1, 0}, std::pair{-1, 0}, std::pair{0, 1}, std::pair{0, -1}}) {
      const int col = node.col + right, row = node.row + down;
      if (NumberAt(col, row) >= 0) continue;
      // Separating a cell from what is one photo's own is a seam, too, and must be worth its cost.
      const double cost = 2 * node.difference + kLength * usual_;
      if (HasFirst(col, row)) to_first += kOwn * cost;
      if (HasSecond(col, row)) to_second += kOwn * cost;
    }
    const double beyond =
        shares_->Beyond(photo_[0], photo_[1],
                        first_.grid.GroundFromPixel(node.col + common_.in_first.col + 0.5,
                                                    node.row + common_.in_first.row + 0.5));
    (beyond < 0 ? to_first : to_second) += kFarther * usual_ * std::abs(beyond);
    graph->addTermWeights(number, to_first, to_second);
  }

  static constexpr double kOwn = 1000;  // the border of the strip is no place for a seam

  const PhotoCells &first_, &second_;
  std::array<std::size_t, 2> photo_;
  CommonCells common_;
  Shares* shares_;
  std::vector<int> numbers_;  // by cell of the common window; -1: not in both
  std::vector<Node> nodes_;
  double usual_ = 0;
};

}  // namespace

Seamlines SeamlinesOfLeastDifference(const std::vector<SeamPhoto>& photos,
                                     const std::vector<PhotoCells>& cells) {
  Shares shares(photos, cells);
  for (std::size_t i = 0; i < cells.size(); ++i)
    for (std::size_t j = i + 1; j < cells.size(); ++j)
      if (Common(cells[i].grid, cells[j].grid).in_first.width > 0)
        PairCut(cells, i, j, &shares).Do();
  std::vector<std::string> names;
  for (const SeamPhoto& photo : photos) names.push_back(photo.name);
  return Seamlines::OfCells(names, shares.Grid(), shares.Photos());
}

}  // namespace orient::ortho
