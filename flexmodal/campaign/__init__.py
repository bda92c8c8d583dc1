"""Measured data, and the only door to Universal File Format files. Knows no robot."""

from flexmodal.campaign.band_pass import band_pass_blow as band_pass_blow
from flexmodal.campaign.blow import Blow as Blow
from flexmodal.campaign.campaign import Campaign as Campaign
from flexmodal.campaign.campaign import CampaignPoint as CampaignPoint
from flexmodal.campaign.campaign import CampaignPosture as CampaignPosture
from flexmodal.campaign.estimate import estimate_frfs as estimate_frfs
from flexmodal.campaign.mode_table import ModeTable as ModeTable
from flexmodal.campaign.noise import noise_floor as noise_floor
from flexmodal.campaign.noise import record_variance as record_variance
from flexmodal.campaign.quality import QualityFlag as QualityFlag
from flexmodal.campaign.quality import QualityLimits as QualityLimits
from flexmodal.campaign.quality import check_blows as check_blows
from flexmodal.campaign.read_campaign import CampaignReport as CampaignReport
from flexmodal.campaign.read_campaign import check_campaign as check_campaign
from flexmodal.campaign.read_campaign import read_campaign as read_campaign
from flexmodal.campaign.records import FrfRecords as FrfRecords
from flexmodal.campaign.trial import Trial as Trial
from flexmodal.campaign.trial import Window as Window
from flexmodal.campaign.trial import repeat_groups as repeat_groups
from flexmodal.campaign.uff import write_frf as write_frf
from flexmodal.campaign.window import added_decay as added_decay
from flexmodal.campaign.window import without_window as without_window
from flexmodal.campaign.write_campaign import write_campaign as write_campaign
