"""Who walks in the hall: build, skin, hair, clothes, gait of every person."""

CAST = {
    "person_1": {  # woman, tan trench coat, long brown hair
        "build": {"height": 1.69, "female": 1.0, "weight": -0.2}, "skin": "#dfae90", "seed": 100,
        "hair": {"colour": "#3b2417", "hairline": "long", "thickness": 0.016, "style": "long", "ears": False, "lips": "#b2575a", "lashes": 0.0028, "eyes": "#5a4030"},
        "top": {"style": "coat", "colour": "#b99464", "shirt": "#f2efe9", "hem": 0.56, "flare": 0.024, "folds": 1.1, "waisted": 1.0},
        "bottom": {"style": "trousers", "colour": "#23252c", "fit": 0.15}, "shoes": {"colour": "#2a1b14", "pointed": 0.6},
        "bag": {"kind": "right_hand", "colour": "#6e2a22", "radii": (0.05, 0.11, 0.15)}, "gait": {"carry": "right", "right_swing": 8, "hip_yaw": 7, "hip_roll": 4, "width": 0.62}},
    "person_2": {  # man, navy suit, briefcase
        "build": {"height": 1.81, "shoulders": 1.04}, "skin": "#d8a382", "seed": 200,
        "hair": {"colour": "#2e2117", "hairline": "short", "thickness": 0.011, "quiff": 0.7, "beard": 0.18},
        "top": {"style": "jacket", "colour": "#27324d", "shirt": "#e6ecf5", "tie": "#7c1f2b", "hem": 0.80, "flare": 0.010, "folds": 0.8},
        "bottom": {"style": "trousers", "colour": "#262f47", "fit": 0.55}, "shoes": {"colour": "#1d1512", "pointed": 0.4},
        "bag": {"kind": "left_hand", "colour": "#4a2f1d", "radii": (0.045, 0.14, 0.20)}, "gait": {"carry": "left", "left_swing": 8}},
    "person_3": {  # woman, red sweater, jeans, black bob, backpack
        "build": {"height": 1.62, "female": 1.0}, "skin": "#e6bd98", "seed": 300,
        "hair": {"colour": "#17120f", "hairline": "long", "thickness": 0.015, "style": "bob", "ears": False, "eyes": "#2a1a12", "lashes": 0.0026},
        "top": {"style": "sweater", "colour": "#b02a2c", "hem": 0.90, "straps": [("backpack", "#2f3b37")], "weave": 0.08},
        "bottom": {"style": "jeans", "colour": "#2d415f", "fit": 0.1}, "shoes": {"colour": "#e9e7e2", "sole": "#f7f7f5"},
        "bag": {"kind": "backpack", "colour": "#35463f"}, "gait": {"hip_roll": 4, "width": 0.7}},
    "person_4": {  # man, mustard hoodie, dark jeans, beard
        "build": {"height": 1.78, "weight": 0.1}, "skin": "#8d5a3b", "seed": 400,
        "hair": {"colour": "#14100e", "hairline": "short", "thickness": 0.008, "strands": 0, "beard": 0.85, "eyes": "#2a1a12"},
        "top": {"style": "hoodie", "colour": "#c98e22", "hem": 0.90, "cuffs": "#b57e1c"},
        "bottom": {"style": "jeans", "colour": "#22262f", "fit": 0.35}, "shoes": {"colour": "#f0f0ee", "sole": "#ffffff"},
        "gait": {"sway": 0.026, "lean": 4, "left_swing": 24, "right_swing": 24}},
    "person_5": {  # woman, white blouse, black skirt, blonde ponytail
        "build": {"height": 1.72, "female": 1.0, "weight": -0.1}, "skin": "#ecc3a8", "seed": 500,
        "hair": {"colour": "#c39a58", "hairline": "high", "thickness": 0.011, "style": "ponytail", "brows": "#8a6638", "lips": "#c05a60", "eyes": "#4d6a80", "lashes": 0.0026},
        "top": {"style": "blouse", "colour": "#eeeef0", "folds": 0.45, "hem": 0.98, "flare": 0.0, "waisted": 0.8},
        "bottom": {"style": "skirt", "colour": "#1f2026", "hem": 0.50, "flare": 0.025, "tights": "#2b2524"}, "shoes": {"colour": "#16161a", "pointed": 0.8, "top": 0.055},
        "gait": {"hip_yaw": 7.5, "hip_roll": 4.5, "width": 0.55, "stride": 0.94}},
    "person_6": {  # heavy man, white shirt, charcoal trousers, bald
        "build": {"height": 1.84, "weight": 0.9}, "skin": "#6a4129", "seed": 600,
        "hair": {"colour": "#1a1412", "hairline": None, "thickness": 0, "beard": 0.5, "glasses": True, "eyes": "#20140e"},
        "top": {"style": "shirt", "colour": "#cfdcec", "folds": 0.55, "hem": 0.97, "flare": 0.0, "waisted": 0.0},
        "bottom": {"style": "trousers", "colour": "#3c3f45", "fit": 0.9}, "shoes": {"colour": "#3a2418", "pointed": 0.2},
        "gait": {"sway": 0.03, "hip_roll": 2.0, "width": 1.05, "stride": 0.93, "arm_in": 4.0, "lean": 1.0}},
    "person_7": {  # older woman, grey hair, green cardigan, dotted dress
        "build": {"height": 1.60, "female": 1.0, "weight": 0.55}, "skin": "#dcb199", "seed": 700,
        "hair": {"colour": "#a9a7a4", "hairline": "short", "thickness": 0.020, "crown": 0.5, "style": "curly", "strands": 0, "brows": "#87827c", "glasses": True, "eyes": "#50606a"},
        "top": {"style": "cardigan", "colour": "#2f6650", "shirt": "#5c2c52", "hem": 0.86, "flare": 0.02, "weave": 0.07},
        "bottom": {"style": "skirt", "colour": "#5c2c52", "dots": "#d9b6cf", "hem": 0.40, "flare": 0.06, "tights": "#54433c"}, "shoes": {"colour": "#2b211e"},
        "bag": {"kind": "left_hand", "colour": "#202228", "radii": (0.05, 0.09, 0.13)}, "gait": {"stride": 0.85, "cadence": 0.96, "carry": "left", "left_swing": 6, "right_swing": 14, "lean": 5}},
    "person_8": {  # boy, teal T-shirt, shorts, small backpack
        "build": {"height": 1.34, "weight": -0.35, "head": 1.20, "legs": 0.96, "shoulders": 0.92, "female": 0.3}, "skin": "#e4b694", "seed": 800,
        "hair": {"colour": "#6b4526", "hairline": "short", "thickness": 0.017, "quiff": 0.3, "eyes": "#5a6b3c", "flush": 0.9},
        "top": {"style": "tee", "colour": "#1f8a8c", "sleeves": "short", "print": "#f2d34b", "hem": 0.88, "straps": [("backpack", "#c23b22")]},
        "bottom": {"style": "shorts", "colour": "#5d5a4c"}, "shoes": {"colour": "#c9402c", "sole": "#f2f2f2"},
        "bag": {"kind": "backpack", "colour": "#c8442b", "size": 0.92}, "gait": {"cadence": 1.05, "left_swing": 26, "right_swing": 26}},
    "person_9": {  # man, olive jacket over a T-shirt, beige chinos, shoulder bag
        "build": {"height": 1.74, "weight": -0.3}, "skin": "#b98058", "seed": 900,
        "hair": {"colour": "#15110f", "hairline": "high", "thickness": 0.014, "quiff": 1.0, "beard": 0.25, "eyes": "#2d1b10"},
        "top": {"style": "cardigan", "colour": "#545a36", "shirt": "#eceae4", "hem": 0.86, "straps": [("left", "#2c221b")]},
        "bottom": {"style": "chinos", "colour": "#b9a57f", "fit": 0.3}, "shoes": {"colour": "#5a3a22", "sole": "#d8d0c0"},
        "bag": {"kind": "left", "colour": "#33281f"}, "gait": {"right_swing": 22, "left_swing": 14, "arm_in": 8.0}},
    "person_10": {  # woman, teal dress, dark skin, afro
        "build": {"height": 1.70, "female": 1.0, "weight": 0.15}, "skin": "#7a4a30", "seed": 1000,
        "hair": {"colour": "#1a1310", "hairline": "short", "thickness": 0.02, "style": "afro", "strands": 0, "lips": "#8e3b3f", "lashes": 0.0028, "eyes": "#22140d", "ears": False},
        "top": {"style": "vneck", "colour": "#1d6f86", "sleeves": "elbow", "hem": 0.52, "flare": 0.030, "waisted": 1.0, "dots": "#e8e2c8"},
        "bottom": {"style": "legs"}, "shoes": {"colour": "#d9c9a8", "pointed": 0.7, "top": 0.05},
        "gait": {"hip_yaw": 7, "hip_roll": 4.5, "width": 0.6}},
    "person_11": {  # young man, grey T-shirt, blue jeans, curly hair
        "build": {"height": 1.77, "weight": -0.25}, "skin": "#e0ae8c", "seed": 1100,
        "hair": {"colour": "#4a2f1c", "hairline": "short", "thickness": 0.016, "style": "curly", "strands": 0, "eyes": "#4a6a4a", "beard": 0.12},
        "top": {"style": "tee", "colour": "#7d828a", "sleeves": "short", "print": "#e9e4d6", "hem": 0.88},
        "bottom": {"style": "jeans", "colour": "#34507a", "fit": 0.4}, "shoes": {"colour": "#23262c", "sole": "#f2f2f2"}},
}
