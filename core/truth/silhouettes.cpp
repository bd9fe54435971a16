#include "core/truth/silhouettes.h"

#include <algorithm>
#include <numeric>

#include "core/truth/id_census.h"

namespace camrig::truth {

std::vector<std::size_t> group_apart(std::span<const PixelBox> boxes) {
    std::vector<std::size_t> order(boxes.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, std::ranges::greater(),
                             [&](std::size_t i) { return std::int64_t{boxes[i].width} * boxes[i].height; });
    const auto touch = [](const PixelBox& a, const PixelBox& b) {
        return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
    };
    std::vector<std::size_t> group_of(boxes.size());
    std::vector<std::vector<std::size_t>> groups;
    for (const std::size_t i : order) {
        auto fits = std::ranges::find_if(groups, [&](const auto& members) {
            return std::ranges::none_of(members, [&](std::size_t other) { return touch(boxes[i], boxes[other]); });
        });
        if (fits == groups.end()) fits = groups.insert(groups.end(), std::vector<std::size_t>{});
        fits->push_back(i);
        group_of[i] = static_cast<std::size_t>(fits - groups.begin());
    }
    return group_of;
}

FindSilhouettes silhouettes_from(DrawAlone draw_alone) {
    return [draw_alone = std::move(draw_alone)](
               std::span<const ObjectId> objects,
               std::span<const PixelBox> reaches) -> Result<std::vector<frame::Silhouette>> {
        const std::vector<std::size_t> group_of = group_apart(reaches);
        const std::size_t groups = group_of.empty() ? 0 : *std::ranges::max_element(group_of) + 1;
        std::vector<frame::Silhouette> silhouettes(objects.size());
        std::vector<ObjectId> together;
        for (std::size_t group = 0; group < groups; ++group) {
            together.clear();
            for (std::size_t i = 0; i < objects.size(); ++i)
                if (group_of[i] == group) together.push_back(objects[i]);
            auto alone = draw_alone(together);
            if (!alone) return std::unexpected(alone.error());
            for (std::size_t i = 0; i < objects.size(); ++i) {
                if (group_of[i] != group) continue;
                silhouettes[i] = silhouette_of(ids_of(**alone), static_cast<std::uint32_t>(objects[i]), reaches[i],
                                               (*alone)->info().size);
            }
        }
        return silhouettes;
    };
}

}  // namespace camrig::truth
