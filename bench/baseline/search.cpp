// Neighbours by PCL.
#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/search/organized.h>

#include <stdexcept>

#include "baseline/stages.h"

namespace handhold::baseline {

PclCloud::Ptr to_pcl(const CloudView& view) {
  PclCloud::Ptr cloud(new PclCloud);
  cloud->width = view.width;
  cloud->height = view.height;
  cloud->is_dense = false;
  cloud->resize(view.size());
  cloud->width = view.width;  // resize() makes the cloud unorganized
  cloud->height = view.height;
  for (std::size_t i = 0; i < view.size(); ++i) {
    const float* p = view.point(i);
    (*cloud)[i] = pcl::PointXYZ(p[0], p[1], p[2]);
  }
  return cloud;
}

struct RadiusSearch::Impl {
  std::unique_ptr<pcl::KdTreeFLANN<pcl::PointXYZ>> tree;
  std::unique_ptr<pcl::search::OrganizedNeighbor<pcl::PointXYZ>> organized;
  pcl::Indices indices;
  std::vector<float> distances2;
};

RadiusSearch::RadiusSearch(const PclCloud::Ptr& cloud, Search kind) : impl_(new Impl) {
  if (kind == Search::kKdTree) {
    impl_->tree.reset(new pcl::KdTreeFLANN<pcl::PointXYZ>(/*sorted=*/false));
    impl_->tree->setInputCloud(cloud);
    return;
  }
  if (cloud->height < 2) throw std::invalid_argument("baseline: organized search needs an organized cloud, height > 1");
  impl_->organized.reset(new pcl::search::OrganizedNeighbor<pcl::PointXYZ>(/*sorted_results=*/false));
  impl_->organized->setInputCloud(cloud);
  if (!impl_->organized->isValid())
    throw std::invalid_argument("baseline: PCL finds no projection for this cloud; the kd-tree takes any cloud");
}

RadiusSearch::~RadiusSearch() = default;

const std::vector<int>& RadiusSearch::find(const Eigen::Vector3f& center, double radius) {
  const pcl::PointXYZ query(center.x(), center.y(), center.z());
  if (impl_->tree)
    impl_->tree->radiusSearch(query, radius, impl_->indices, impl_->distances2);
  else
    impl_->organized->radiusSearch(query, radius, impl_->indices, impl_->distances2);
  return impl_->indices;
}

}  // namespace handhold::baseline
