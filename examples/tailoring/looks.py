"""The looks of the three garments: materials, sets, painted weights and recipes."""
from .stage import Look

TSHIRT = Look(
    doc="A T-shirt with set-in sleeves, a ribbed neckband and a chest pocket, in centimetres.",
    colours={"jersey": (0.36, 0.52, 0.66), "rib": (0.22, 0.32, 0.44), "pocket": (0.80, 0.62, 0.36)},
    materials={"neckband": "rib", "pocket": "pocket"},
    sets={"stiff": ["neckband", "pocket"], "trim": ["neckband"],
          "sleeves": ["sleeve_left", "sleeve_right"],
          "cover": ["neckband", "sleeve_left", "sleeve_right"]},
    display="constant",
    fine={"armholes": 9, "neck_seam": 7, "cuff_hem": 6},
    thick={"neckband": 0.9, "pocket": 0.7},
    constraints=["hem_stitch", "pocket_hem", "chest_line"],
    min_length=0.7, max_length=1.7,
    grains={"sleeve_left": (-0.63, 0.78, 0), "sleeve_right": (0.63, 0.78, 0)},
    hint="The sleeves and the neckband are welded to the body; the pocket lies upon it.")

TROUSERS = Look(
    doc="Trousers with a waistband, belt loops, a fly and back pockets, in centimetres.",
    colours={"denim": (0.20, 0.28, 0.42), "waist": (0.26, 0.33, 0.45), "trim": (0.55, 0.42, 0.26)},
    materials={"waistband": "waist", "fly": "waist", "pocket_left": "waist",
               "pocket_right": "waist", **{f"belt_loop_{k}": "trim" for k in range(1, 6)}},
    sets={"stiff": ["waistband", "fly", *(f"belt_loop_{k}" for k in range(1, 6))],
          "trim": ["waistband", *(f"belt_loop_{k}" for k in range(1, 6))],
          "seat": ["back_left", "back_right", "pocket_left", "pocket_right"]},
    display="vertex",
    fine={"crotch": 12, "waist_seam": 6, "hem": 5, "fly_seam": 4},
    thick={"waistband": 1.0, "fly": 0.8, "pocket_left": 0.7, "pocket_right": 0.7,
           **{f"belt_loop_{k}": 0.9 for k in range(1, 6)}},
    constraints=["leg_folds", "hem_stitch", "pocket_hem", "waistband_fold"],
    min_length=0.8, max_length=1.9,
    hint="Pockets, fly and belt loops are pieces of their own which lie upon the body.")

_COAT_TRIM = ["collar", "cuff_left", "cuff_right", "flap_left", "flap_right", "half_belt", "welt"]
COAT = Look(
    doc="An open coat with notched lapels, a folded collar, turned back cuffs, facings, patch "
        "pockets with flaps and a half belt, in centimetres.",
    colours={"wool": (0.74, 0.60, 0.44), "velvet": (0.46, 0.27, 0.22), "horn": (0.80, 0.72, 0.56)},
    materials={"collar": "velvet", "cuff_left": "velvet", "cuff_right": "velvet",
               "flap_left": "velvet", "flap_right": "velvet", "half_belt": "horn", "welt": "horn"},
    sets={"stiff": ["collar", "cuff_left", "cuff_right", "half_belt", "front_left", "front_right"],
          "trim": _COAT_TRIM,
          "sleeves": [f"sleeve_{p}_{s}" for s in ("left", "right") for p in ("upper", "under")],
          "upon_body": ["pocket_left", "pocket_right", "flap_left", "flap_right", "half_belt",
                        "welt"]},
    display="uniform",
    fine={"cuff_hem": 11, "collar_fold": 9, "collar_edge": 5, "armholes": 8, "roll_line": 5,
          "lapel_edge": 4, "placket": 4},
    thick={"collar": 0.9, "cuff_left": 1.0, "cuff_right": 1.0, "half_belt": 0.9, "welt": 0.8,
           "flap_left": 0.9, "flap_right": 0.9, "pocket_left": 0.7, "pocket_right": 0.7},
    constraints=["collar_fold", "roll_line", "placket", "placket_stitch", "cuff_fold",
                 "pocket_hem", "waist_line", "elbow_line"],
    min_length=1.0, max_length=2.6,
    grains={**{f"sleeve_{p}_left": (-0.63, 0.78, 0) for p in ("upper", "under")},
            **{f"sleeve_{p}_right": (0.63, 0.78, 0) for p in ("upper", "under")},
            "collar": (0, -1, 0), "cuff_left": (0.63, -0.78, 0), "cuff_right": (-0.63, -0.78, 0)},
    translate=(0, 100, 0), cylinder=True,
    # Where the armhole meets the under sleeve more than two panels meet; keeping that corner sharp
    # would fold the narrow row of faces below it over in UV.
    uv_corners="cornersOnly",
    hint="Collar, cuffs and sleeves are welded to the body; the lapels are the fronts' own cloth "
         "folded over; pockets, flaps, welt and half belt lie upon the body.")
