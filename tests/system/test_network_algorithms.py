"""The pure parts of examples/network against known answers: auctions, vision graph, strategies, filters, links, the market on made-up sightings."""

import json
import sys

import numpy as np
import pytest

from conftest import REPOSITORY

sys.path.insert(0, str(REPOSITORY))
from examples.network import camsim, plots  # noqa: E402
from examples.network.auction import vickrey  # noqa: E402
from examples.network.chance import chance  # noqa: E402
from examples.network.close_ups import DWELL_S, HeadNode  # noqa: E402
from examples.network.consensus import Icf  # noqa: E402
from examples.network.kalman import Kalman  # noqa: E402
from examples.network.messages import Link, Message  # noqa: E402
from examples.network.node import phases, run_phase  # noqa: E402
from examples.network.nodes import Plan, communication_graph, make_node  # noqa: E402
from examples.network.ownership import Ownership  # noqa: E402
from examples.network.replay import replay  # noqa: E402
from examples.network.score import score  # noqa: E402
from examples.network.sighting import Sighting, alike  # noqa: E402
from examples.network.strategies import STRATEGIES  # noqa: E402
from examples.network.tracks import Tracks  # noqa: E402
from examples.network.vision_graph import EVAPORATION, VisionGraph  # noqa: E402

PERIOD_NS = 250_000_000
RED, BLUE = np.r_[255, np.zeros(15), np.zeros(15), 255, np.zeros(15), 255], np.r_[np.zeros(8), 255, np.zeros(7), np.zeros(15), 255, np.zeros(15), 255]


def sighting(x, y, value, colours=RED, spread=0.1):
    return Sighting(np.array([x, y], float), np.eye(2) * spread**2, value, colours.astype(np.uint8), (10.0, 10.0, 20.0, 50.0))


# Auctions (Vickrey 1961)

@pytest.mark.parametrize("reserve, bids, winner, price", [
    (0.2, {"b": 0.5, "c": 0.9, "d": 0.7}, "c", 0.7),  # the highest at the second highest value
    (0.6, {"b": 0.9, "c": 0.5}, "b", 0.6),  # the seller's own value is a bid
    (0.9, {"b": 0.5}, "a", 0.0),  # nobody sees it better
    (0.5, {"b": 0.5}, "a", 0.0),  # nor is a tie worth a hand-over
    (0.1, {"c": 0.5, "b": 0.5}, "b", 0.5),  # all who know the bids know the winner
    (0.1, {}, "a", 0.0),
])  # fmt: skip
def test_the_highest_bid_wins_at_the_second_price(reserve, bids, winner, price):
    assert vickrey("a", reserve, bids) == (winner, price)


def test_nobody_gains_by_another_bid_than_the_true_value():
    for trial in range(200):
        true, others = chance(trial, "true"), {"c": chance(trial, "c"), "d": chance(trial, "d")}
        def gain(bid):
            sale = vickrey("a", 0.1, {"b": bid, **others})
            return true - sale.price if sale.winner == "b" else 0.0
        assert all(gain(bid / 20) <= gain(true) + 1e-12 for bid in range(21))


# Vision graph and strategies (Esterle et al. 2014)

def test_pheromone_grows_by_hand_overs_and_evaporates():
    graph = VisionGraph()
    graph.reinforce("b")
    graph.reinforce("b")
    graph.reinforce("c")
    for _ in range(100):
        graph.evaporate()
    assert graph.links() == pytest.approx({"b": 2 * EVAPORATION**100, "c": EVAPORATION**100})
    assert graph.strongest() == pytest.approx(2 * 0.6057704, rel=1e-6)


def test_smooth_and_step_ask_with_the_published_probabilities():
    graph = VisionGraph()
    for _ in range(3):
        graph.reinforce("b")
    graph.reinforce("c")
    for _ in range(200):
        graph.evaporate()  # b: 3 * 0.367, c: 0.367, d: 0
    smooth, step = STRATEGIES["ASM"], STRATEGIES["AST"]
    tau = EVAPORATION**200
    for strategy, expected in ((smooth, [1.0, (1 + tau) / (1 + 3 * tau), 1 / (1 + 3 * tau)]), (step, [1.0, tau, 0.1])):
        assert [strategy.probability(graph, peer) for peer in "bcd"] == pytest.approx(expected)
        asked = [peer for draw in range(4000) for peer in strategy.asks(["b", "c", "d"], graph, draw)]
        assert [asked.count(peer) / 4000 for peer in "bcd"] == pytest.approx(expected, abs=0.03)
    assert step.asks(["d"], graph, 1) == ["d"], "nobody drawn: everybody is asked"
    assert STRATEGIES["ABC"].asks(["b", "d"], graph, 1) == ["b", "d"] and STRATEGIES["none"].asks(["b"], graph, 1) == []


def test_passive_cameras_offer_what_they_are_about_to_lose():
    active, passive = STRATEGIES["ABC"], STRATEGIES["PBC"]
    assert active.offers(0.9, 0.5)
    assert [passive.offers(*now) for now in ((0.9, 0.5), (0.3, 0.5), (0.05, 0.04), (0.05, 0.2), (0.0, 0.0))] == [False, False, False, True, True]
    assert not STRATEGIES["none"].offers(0.0, 0.9)


def test_camsims_trade_of_utility_against_communication():
    """As published, and as CamSim itself gives for 16 cameras and 4 objects: communication ABC > PBC > ASM > PSM > AST > PST; smooth keeps nearly all of the utility."""
    of = camsim.table(steps=400, seeds=3)
    by_searches = sorted((name for name in of if name != "none"), key=lambda name: -of[name]["searches"])
    assert by_searches == ["ABC", "PBC", "ASM", "PSM", "AST", "PST"]
    assert of["ABC"]["searches"] == 400 * camsim.OBJECTS * (camsim.CAMERAS - 1)
    assert of["ASM"]["utility_share"] > 0.9 and of["AST"]["utility_share"] > 0.65 and of["none"]["utility_share"] < 0.3
    assert of["AST"]["searches_share"] < 0.35 < of["ASM"]["searches_share"] < 0.8


# Filters (Kamal, Farrell, Roy-Chowdhury 2013)

def ring(count):
    return {i: [(i - 1) % count, (i + 1) % count] for i in range(count)}


def consensus_and_central(rounds, steps=20):
    """Largest difference between nodes of a ring, two of which see the object, and a Kalman filter that has their measurements; and that of their information."""
    neighbours, rng = ring(6), np.random.default_rng(5)
    start = np.diag([1.0, 1.0, 2.0, 2.0])
    nodes = {i: Icf(6, np.array([1.0, 2.0, 0, 0]), start) for i in neighbours}
    central = Kalman(np.array([1.0, 2.0]), np.eye(2))
    central.P = np.linalg.inv(start)
    for step in range(steps):
        place = np.array([1.0 + 0.3 * step, 2.0])
        measured = {i: (place + rng.normal(0, 0.2, 2), np.array([[0.04 * (i + 1), 0.01], [0.01, 0.09]])) for i in (0, 2)}
        central.predict(0.25)
        for position, covariance in measured.values():
            central.update(position, covariance)
        for i, node in nodes.items():
            node.predict(0.25)
            node.measure([measured[i]] if i in measured else [])
        for _ in range(rounds):
            held = {i: (node.v, node.V) for i, node in nodes.items()}
            for i, node in nodes.items():
                node.mix([held[j] for j in neighbours[i]], 1 / 3)
        for node in nodes.values():
            node.estimate()
    return max(np.abs(node.x - central.x).max() for node in nodes.values()), max(np.abs(np.linalg.inv(node.J) - central.P).max() for node in nodes.values())


def test_consensus_filters_become_the_central_filter():
    off_x, off_P = consensus_and_central(rounds=120)
    assert off_x < 1e-9 and off_P < 1e-9
    errors = [consensus_and_central(rounds)[0] for rounds in (1, 3, 10, 30)]
    assert errors == sorted(errors, reverse=True) and errors[0] > 0.01, errors


def test_a_walker_is_followed_and_a_gate_is_in_standard_deviations():
    walker = Kalman(np.array([0.0, 0.0]), np.eye(2) * 0.04)
    for step in range(1, 40):
        walker.predict(0.25)
        walker.update(np.array([0.3 * step, 0.0]), np.eye(2) * 0.04)
    assert walker.x == pytest.approx([11.7, 0, 1.2, 0], abs=0.02)
    for step in range(1, 13):  # round the corner
        walker.predict(0.25)
        walker.update(np.array([11.7, 0.3 * step]), np.eye(2) * 0.04)
    assert walker.x == pytest.approx([11.7, 3.6, 0, 1.2], abs=0.15)
    spread = walker.P[:2, :2] + np.eye(2) * 0.04
    assert walker.distance2(walker.x[:2] + [2 * np.sqrt(spread[0, 0]), 0], np.eye(2) * 0.04) == pytest.approx(4, rel=1e-6)


# Links and messages

def test_links_lose_their_share_the_same_messages_each_time_and_count_all():
    def arrive(seed):
        link = Link(0.3, seed)
        sent = [Message("a", to, "search", step, {"object": "x"}) for step in range(500) for to in ("b", "c")]
        return [message for one in sent for message in link.passes([one])], link
    (first, link), (second, _), (other, _) = arrive(1), arrive(1), arrive(2)
    assert first == second != other
    assert link.lost == 1000 - len(first) and 0.65 < len(first) / 1000 < 0.75
    assert link.sent["search"] == 1000
    assert link.bytes["search"] == sum(len(f"net.b.search") + len(json.dumps({"from": "a", "t": step, "object": "x"}, separators=(",", ":"))) for step in range(500)) * 2


@pytest.mark.parametrize("subject, data", [("net.a", b"{}"), ("net.a.b", b"{"), ("net.a.b", b"[]"), ("net.a.b", b'{"from":"x"}'), ("net.a.b", b'{"from":"x","t":"y"}')])
def test_what_is_no_message_is_told_so(subject, data):
    with pytest.raises(ValueError, match="is no message of this network"):
        Message.decode(subject, data)


def test_messages_arrive_as_they_were_sent():
    message = Message("a", "b", "found", 5, {"object": "o", "value": 0.25})
    assert Message.decode(message.subject(), message.encode()) == message


# The market on made-up sightings

def network(strategy="ABC", cameras=3, heads=0, **more):
    calibration = {"size": [480, 360], "intrinsics": {"fx": 300, "fy": 300, "cx": 239.5, "cy": 179.5}, "pose": {"position": [0, 0, 3], "pan_deg": 0, "tilt_deg": 0}}
    places = {f"c{i}": {**calibration, "name": f"c{i}", "pose": {**calibration["pose"], "position": [6 * i, 0, 3]}} for i in range(cameras)}
    return Plan(places, {f"h{i}": {**calibration, "name": f"h{i}"} for i in range(heads)}, strategy, **more)


def passing(steps=40):
    """Somebody in red walks from c0's view through c1's into c2's: views overlap, and each camera sees them best in its middle."""
    seen = {f"c{i}": {} for i in range(3)}
    for step in range(steps):
        x = 0.4 * step
        for i in range(3):
            value = max(0.0, 1 - abs(x - (2 + 6 * i)) / 4)
            seen[f"c{i}"][step * PERIOD_NS] = [sighting(x, 3, value)] if value > 0 else []
    return seen


def play(plan, seen):
    nodes = [make_node(plan, name) for name in plan.names()]
    times = sorted(next(iter(seen.values())))
    return nodes, replay(nodes, times, seen, plan.rounds, plan.loss, plan.seed)


def owners(logs):
    """By step, (object, owner) of all that is owned."""
    return [[(one["object"], one["owner"]) for told in step for one in told.get("owned", [])] for step in zip(*logs.values())]


@pytest.mark.parametrize("strategy", ["ABC", "ASM", "AST", "PBC", "PSM", "PST", "central"])
def test_one_person_keeps_one_name_and_one_owner_across_three_cameras(strategy):
    _, logs = play(network(strategy), passing())
    owned = owners(logs)
    assert len({name for step in owned for name, _ in step}) == 1
    assert max(map(len, owned)) == 1
    assert [camera for camera in dict.fromkeys(camera for step in owned for _, camera in step)] == ["c0", "c1", "c2"]


def test_active_cameras_hand_over_sooner_and_pay_for_it():
    when, searches = {}, {}
    for strategy in ("ABC", "PBC"):
        nodes, logs = play(network(strategy), passing())
        when[strategy] = next(step for step, owned in enumerate(owners(logs)) if owned and owned[0][1] == "c1")
        searches[strategy] = sum(log[-1]["sent"].get("search", 0) for log in logs.values())
        if strategy == "ABC":
            assert nodes[0].market.graph.pheromone("c1") > 0.7 and nodes[0].market.graph.pheromone("c2") == 0
    assert when["ABC"] < when["PBC"] and searches["ABC"] > 2 * searches["PBC"] > 0


def test_a_hand_over_whose_messages_are_lost_leaves_the_object_with_one_of_the_two():
    owned = owners(play(network("ABC", loss=0.2), passing())[1])
    unowned = "".join(" " if step else "x" for step in owned[6:-4])
    assert "xxxx" not in unowned, "an award that nobody has accepted is taken back"
    assert owned[-5][-1][1] == "c2"


def test_people_who_pass_each_other_keep_their_names():
    seen = {"c0": {}, "c1": {}}
    for step in range(30):
        x = 0.4 * step
        people = [sighting(x, 3, 0.8, RED), sighting(12 - x, 3.6, 0.7, BLUE)]
        seen["c0"][step * PERIOD_NS], seen["c1"][step * PERIOD_NS] = people, [sighting(*one.position, 0.5, one.colours) for one in people]
    _, logs = play(network("ABC", cameras=2), seen)
    ends = [{one["object"]: one["floor"][0] for told in step for one in told.get("owned", [])} for step in (list(zip(*logs.values()))[5], list(zip(*logs.values()))[-1])]
    assert len(ends[0]) == 2 and ends[0].keys() == ends[1].keys()
    (left,) = (name for name, x in ends[0].items() if x < 6)
    assert ends[1][left] > 10, "who came from the left is on the right now, by the same name"


def test_who_comes_back_is_known_again_and_who_looks_otherwise_is_not():
    for colours, names in ((RED, 1), (BLUE, 2)):
        seen = {"c0": {}, "c1": {}}
        for step in range(60):
            seen["c0"][step * PERIOD_NS] = [sighting(0.3 * step, 3, 0.8)] if step < 15 else []
            seen["c1"][step * PERIOD_NS] = [sighting(12 + 0.1 * step, 3, 0.8, colours)] if step > 40 else []
        owned = owners(play(network("PBC", cameras=2), seen)[1])
        assert len({name for step in owned for name, _ in step}) == names


def test_of_two_names_of_one_person_the_older_stays():
    older, younger = (Ownership(name, ["c0", "c1"], STRATEGIES["ABC"], 1) for name in ("c0", "c1"))
    for market, name in ((older, "0000500-c0-1"), (younger, "0000750-c1-1")):
        market.begin(0)
        market._own(market.tracks.adopt(Kalman(np.array([1.0, 1.0]), np.eye(2) * 0.1), RED), name)
    (asks,) = (message for message in younger.begin(PERIOD_NS) if message.kind == "search" and message.to == "c0")
    (told,) = older.receive(asks)
    assert (told.kind, told.body["object"]) == ("owned", "0000500-c0-1") and older.owned == {"0000500-c0-1"}
    younger.receive(told)
    assert not younger.owned and younger.tracks.all[0].object == "0000500-c0-1"


def test_colours_decide_where_places_do_not():
    tracks = Tracks()
    tracks.advance(0)
    tracks.see([sighting(0, 0, 0.5, RED), sighting(0.02, 0, 0.5, BLUE)])
    tracks.advance(PERIOD_NS)
    tracks.see([sighting(0.02, 0.3, 0.5, RED), sighting(0, 0.3, 0.5, BLUE)])
    assert len(tracks.all) == 2 and all(alike(track.colours, track.sighting.colours) > 0.9 for track in tracks.all)


def test_the_filters_of_all_begin_with_what_the_owner_knows():
    plan = network("ABC", rounds=50)
    nodes, _ = play(plan, {name: {step * PERIOD_NS: ([sighting(2 + 0.2 * step, 3, 0.8)] if name == "c0" else []) for step in range(4)} for name in ("c0", "c1", "c2")})
    (track,) = nodes[0].market.tracks.all
    for node in nodes:
        (one,) = node._filters.values()
        assert one.x == pytest.approx(track.kalman.x, abs=1e-3) and np.linalg.inv(one.J) == pytest.approx(track.kalman.P, abs=1e-3)


def test_all_nodes_of_a_network_with_consensus_know_where_an_object_is():
    plan = network("ABC", rounds=10)
    assert communication_graph(plan) == {"c0": ["c1", "c2"], "c1": ["c0", "c2"], "c2": ["c0", "c1"]}
    nodes, logs = play(plan, {name: {step * PERIOD_NS: ([sighting(2 + 0.2 * step, 3, 0.8)] if name == "c0" else []) for step in range(20)} for name in ("c0", "c1", "c2")})
    estimates = np.array([next(iter(node._filters.values())).x for node in nodes])
    assert estimates[:, :2] == pytest.approx(np.tile([5.8, 3], (3, 1)), abs=0.05)


# Heads

def test_a_head_takes_one_of_two_announced_turns_to_them_and_leaves_after_its_time():
    seen = {"c0": {step * PERIOD_NS: [sighting(8 + 0.1 * step, 4, 0.9, RED), sighting(3, -6, 0.9, BLUE)] for step in range(60)}}
    plan = network("ABC", cameras=1, heads=1)
    _, logs = play(plan, seen)
    targets = [told["target"] for told in logs["h0"]]
    stays = [name for name in dict.fromkeys(targets) if name]
    assert len(stays) == 2, "both had their turn"
    begin, end = targets.index(stays[0]), targets.index(stays[1])
    assert targets[begin:end].count(stays[0]) == DWELL_S * 1e9 / PERIOD_NS
    last = begin + targets[begin:end].count(stays[0]) - 1
    place = {one["object"]: one["floor"] for one in logs["c0"][last]["owned"]}[stays[0]]
    pan_deg, tilt_deg, zoom = logs["h0"][last]["aim"]
    assert pan_deg == pytest.approx(np.degrees(np.arctan2(place[1], place[0])), abs=1.5)
    assert tilt_deg == pytest.approx(-np.degrees(np.arctan2(3 - 0.875, np.hypot(*place))), abs=0.5) and zoom > 1


def test_who_had_a_close_up_waits_for_the_next():
    head = HeadNode("h", [0, 0, 3], 0, 0, 1.0, 0.25)
    head.begin(0, [])
    head.receive([Message("c", "h", "award", 0, {"object": "near", "x": [2, 0, 0, 0], "p": 0.1})])
    now_ns = round((DWELL_S + 0.5) * 1e9)
    head.begin(now_ns, [])
    offers = head.receive([Message("c", "h", "announce", now_ns, {"object": name, "x": x, "p": 0.1}) for name, x in (("near", [2, 0, 0, 0]), ("far", [10, 0, 0, 0]))])
    values = {offer.body["object"]: offer.body["value"] for offer in offers}
    assert values["far"] > values["near"] > 0


def test_a_head_that_hears_nothing_is_free_again():
    head = HeadNode("h", [0, 0, 3], 0, 0, 1.0, 0.25)
    head.begin(0, [])
    head.receive([Message("c", "h", "award", 0, {"object": "o", "x": [5, 0, 0, 0], "p": 0.1})])
    assert head.finish()["target"] == "o"
    said = head.begin(2 * 10**9, [])
    assert head.finish() == {"target": None, "aim": None} and [message.kind for message in said] == ["released"]


# Scores and plots

def test_scores_are_those_of_a_made_up_run():
    """Two people for four steps; one owner is right throughout, the other's object goes to the wrong person in the third step and nobody has the second then."""
    def at(step, floor_b):
        return {"t": step * PERIOD_NS, "people": [
            {"id": 1, "floor": [0, 0], "seen": {"a": {"visible": 1.0, "distance_m": 10, "off_axis": 0.5, "height_px": 100}}},
            {"id": 2, "floor": floor_b, "seen": {"b": {"visible": 0.8, "distance_m": 5, "off_axis": 0.0, "height_px": 100}}},
            {"id": 3, "floor": [50, 50], "seen": {"b": {"visible": 0.1, "distance_m": 5, "off_axis": 0.0, "height_px": 100}}}]}
    truth = [at(step, [5, 0]) for step in range(4)]
    def says(step, *owned):
        return {"t": step * PERIOD_NS, "owned": [{"object": name, "owner": camera, "floor": floor, "value": 0.5} for name, camera, floor in owned],
                "sent": {"search": 2 * step}, "bytes": {"search": 100 * step}, "lost": 0}
    x = ("x", "a", [0.3, 0.4])
    # In the second step a has not heard yet that b has bought y: of two that see it alike the last by name is asked, and nothing was handed over.
    logs = {"a": [says(0, x), says(1, x, ("y", "a", [80, 0])), says(2, x), says(3, x, ("y", "a", [5, 0]))],
            "b": [says(0, ("y", "b", [5, 0])), says(1, ("y", "b", [5, 0])), says(2, ("z", "b", [50, 50.2])), says(3)]}
    got = score(truth, logs, ["a", "b"])
    assert got["people_steps"] == 8 and got["coverage"] == 7 / 8 and got["misses"] == 1 and got["false_positives"] == 0 and got["switches"] == 0
    assert got["error_m"] == pytest.approx((4 * 0.5 + 0) / 7, abs=1e-3)
    one, two = 0.5 / (10 + 0.5), 0.8 / (5 + 0.75)
    assert got["utility"] == pytest.approx(4 * one + 2 * two, abs=1e-3), "of the third step nobody, of the fourth the owner cannot see them"
    assert got["relative_utility"] == pytest.approx((4 * one + 2 * two) / (4 * one + 4 * two), abs=1e-3)
    assert (got["handovers"], got["handovers_right"], got["messages"], got["bytes"]) == (1, 1, 12, 600)


def test_likeness_of_colours_is_bhattacharyyas():
    assert alike(RED, RED) == pytest.approx(1) and alike(RED, BLUE) < 0.75
    assert alike(np.r_[4, 0, 0, 9, 1, 0], np.r_[1, 3, 5, 0, 0, 2]) == pytest.approx((0.5 + 0 + 0) / 3)


def test_plots_put_points_where_they_belong():
    svg = plots.plot("x", "y", {"a<b": [(0, 0), (10, 5)]})
    assert f'cx="{plots.LEFT}.0" cy="{plots.TOP + plots.HEIGHT}.0"' in svg and f'cx="{plots.LEFT + plots.WIDTH}.0" cy="{plots.TOP}.0"' in svg
    assert "a&lt;b" in svg and svg == plots.plot("x", "y", {"a<b": [(0, 0), (10, 5)]})


def test_nothing_is_sent_after_the_last_phase():
    """What the last phase sent would arrive when the next step has begun."""
    plan = network("ABC", heads=1, loss=0.2, rounds=2)
    nodes = {name: make_node(plan, name) for name in plan.names()}
    seen = passing()
    for now_ns in sorted(seen["c0"]):
        boxes = {name: [] for name in nodes}
        for phase in phases(plan.rounds):
            sent = {name: run_phase(node, phase, boxes[name], now_ns, seen.get(name, {}).get(now_ns, []))[0] for name, node in nodes.items()}
            boxes = {name: [message for of in sent.values() for message in of if message.to == name] for name in nodes}
        assert not any(boxes.values()), boxes
