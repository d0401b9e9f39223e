"""The pages a person opens, in one frame: report, checks, gallery, lessons, stability."""
